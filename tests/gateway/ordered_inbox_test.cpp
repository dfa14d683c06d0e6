// What of a peer's `ordered` messages came, came twice, or will never come.
#include "gateway/outbox/ordered_inbox.hpp"

#include <doctest/doctest.h>

namespace arkmesh::gateway {
namespace {

TEST_CASE("each ordered message is taken once, and gaps are counted") {
  // By channel and number; messages without a number are always taken.
  OrderedInbox inbox;
  CHECK(inbox.begin() == 0);
  inbox.announced(0, 0);
  for (const std::uint64_t n : {1u, 2u, 3u}) CHECK(inbox.take("events", n));
  CHECK_FALSE(inbox.take("events", 3));
  CHECK_FALSE(inbox.take("events", 1));
  CHECK(inbox.take("log", 1));
  CHECK(inbox.take("events", 7));
  CHECK(inbox.take("world", 0));
  CHECK(inbox.take("world", 0));
  CHECK(inbox.counters()["received.repeated.events"] == 2);
  CHECK(inbox.counters()["received.missing.events"] == 3);
}

TEST_CASE("a peer's restart is a gap of known size") {
  // What it had announced and did not send is missing; what it numbers anew is taken. What it had sent to an earlier
  // gateway of ours is none of it.
  OrderedInbox inbox;
  CHECK(inbox.begin() == 0);
  inbox.announced(1000, 4);
  CHECK(inbox.take("events", 997));
  CHECK(inbox.take("events", 998));
  inbox.announced(1010, 12);
  CHECK(inbox.take("events", 1000));
  CHECK(inbox.begin() == 10);
  CHECK(inbox.counters()["received.missing.restart"] == 10);
  CHECK(inbox.take("events", 1));
  inbox.announced(2, 2);
  CHECK(inbox.take("events", 2));
  CHECK(inbox.begin() == 0);
}

TEST_CASE("a peer that sends ever new names is remembered in part only") {
  OrderedInbox inbox;
  std::size_t taken = 0;
  for (int i = 0; i < 1000; ++i) taken += inbox.take("c" + std::to_string(i), 1);
  CHECK(taken == OrderedInbox::max_channels);
  CHECK(inbox.counters()["received.refused.too_many_channels"] == 1000 - OrderedInbox::max_channels);
  CHECK(inbox.take("c0", 2));
}

}  // namespace
}  // namespace arkmesh::gateway
