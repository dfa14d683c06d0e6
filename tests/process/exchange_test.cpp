// Event-based exchange between real processes. What networks do to it is tried in tests/labs/exchange_test.cpp.
#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <vector>

#include "lab/result.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/impairment_proxy.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::ImpairmentProxy;
using tests::LabProcesses;

namespace {

// What roark has sent by about the middle of a run: there the proxy holds both labs until a test has done its last
// fault.
constexpr std::size_t middle_bytes = 80'000;

// shark listens on 7941; roark reaches it through the proxy. 600 simulated seconds, 300 periods.
struct Exchanging {
  std::vector<std::string> overrides;
  ImpairmentProxy proxy{7941};
  LabProcesses labs;
  explicit Exchanging(std::vector<std::string> exchange)
      : overrides(std::move(exchange)),
        labs({.overrides = overrides, .through_port = {{{"roark", "shark"}, proxy.port()}}, .first_port = 7940}) {
    proxy.set({.hold_after = middle_bytes});
    labs.start();
  }
  void watch(std::chrono::milliseconds how_long) {
    for (const auto until = std::chrono::steady_clock::now() + how_long; std::chrono::steady_clock::now() < until;)
      labs.period("shark", 50ms);
  }
  void check() {
    const bool ended = labs.ended(300s);
    CAPTURE(labs.lab_output("shark"));
    CAPTURE(labs.lab_output("roark"));
    REQUIRE(ended);
    const std::string expected = lab::hash_text(tests::run_labs({.overrides = overrides}).hash);
    CHECK(labs.result("shark", "final_hash") == expected);
    CHECK(labs.result("roark", "final_hash") == expected);
  }
};

}  // namespace

TEST_CASE("by events, a gateway killed in mid-run and started again changes nothing") {
  // Proves that no event is lost with the gateway that held it.
  Exchanging p({"gate.exchange=event", "run.duration_s=600"});
  for (const char* killed : {"roark", "shark"}) {
    REQUIRE(p.labs.reached("shark", std::string(killed) == "roark" ? 30 : 60, 300s));
    p.labs.gateway(killed).kill();
    REQUIRE(p.labs.period("shark", 200ms) < 280);
    p.watch(1s);
    p.labs.start_gateway(killed);
  }
  p.proxy.set({});
  p.check();
}
