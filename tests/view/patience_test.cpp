// How long the wrong wait.
#include "view/patience.hpp"

#include <doctest/doctest.h>

#include <string>

namespace arkmesh::tests {
namespace {

using view::Patience;
using namespace std::chrono_literals;

const auto address = [](const std::string& text) { return boost::asio::ip::make_address(text); };

TEST_CASE("each further wrong word of an address waits twice as long, up to 5 s, and after a minute it begins anew") {
  Patience patience;
  const Patience::Time t0{};
  for (const Patience::Wait wait : {50ms, 100ms, 200ms, 400ms, 800ms, 1600ms, 3200ms, 5000ms, 5000ms})
    CHECK(patience.after_wrong(address("10.0.0.7"), t0) == wait);
  CHECK(patience.after_wrong(address("10.0.0.8"), t0) == 50ms);
  CHECK(patience.after_wrong(address("10.0.0.7"), t0 + 60s) == 5000ms);
  CHECK(patience.after_wrong(address("10.0.0.7"), t0 + 121s) == 50ms);
}

TEST_CASE("addresses that one sender may choose among count as one, and so do those that are too many") {
  Patience patience;
  const Patience::Time t0{};
  CHECK(patience.after_wrong(address("127.0.0.1"), t0) == 50ms);
  CHECK(patience.after_wrong(address("127.9.9.9"), t0) == 100ms);
  CHECK(patience.after_wrong(address("::1"), t0) == 200ms);
  CHECK(patience.after_wrong(address("::ffff:127.0.0.1"), t0) == 400ms);
  CHECK(patience.after_wrong(address("fe80::1:2:3:4"), t0) == 50ms);
  CHECK(patience.after_wrong(address("fe80::5:6:7:8"), t0) == 100ms);
  for (unsigned i = 0; i < 254; ++i)
    CHECK(patience.after_wrong(boost::asio::ip::address_v4(0x0a000000u + i), t0) == 50ms);
  CHECK(patience.after_wrong(address("10.1.0.1"), t0) == 50ms);
  CHECK(patience.after_wrong(address("10.1.0.2"), t0) == 100ms);
  CHECK(patience.after_wrong(address("10.0.0.0"), t0) == 100ms);
}

}  // namespace
}  // namespace arkmesh::tests
