// What reaches a peer that is slow, stalls, or is cut off again and again; and the accounts of all of it.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "tests/support/network/accounts.hpp"
#include "tests/support/network/two_tcp_labs.hpp"

namespace arkmesh::gateway {
namespace {

using namespace tests;
using namespace std::chrono_literals;
using Wall = std::chrono::steady_clock;

std::string numbered(std::size_t number, std::size_t size) {
  std::string text = std::to_string(number) + " ";
  text.resize(std::max(text.size(), size), 'x');
  return text;
}

// What roark hears of shark's `world`, which is published every 5 ms. The age of a value is how many newer ones there
// are: a busy machine publishes less often, too.
struct WorldOfShark {
  TwoTcpLabs labs;
  std::size_t size, seen = 0, published = 0;
  Wall::time_point due{};
  std::vector<std::size_t> ages;  // when they arrived

  explicit WorldOfShark(std::size_t bytes, const Impairment& impairment = {}) : labs(impairment), size(bytes) {}
  template <class Condition>
  bool until(Condition condition) {
    return labs.until([&] {
      for (; seen < labs.roark.heard.size(); ++seen)
        ages.push_back(published - std::stoul(labs.roark.heard[seen].second));
      if (const auto now = Wall::now(); now >= due) {
        labs.shark.publish("world", numbered(++published, size));
        due = now + 5ms;
      }
      return condition();
    });
  }
  std::size_t oldest(std::size_t from) const {
    return *std::max_element(ages.begin() + static_cast<std::ptrdiff_t>(from), ages.end());
  }
};

TEST_CASE("rules change without cutting a link") {
  // The peer is told at once: what is new passes, and a connection that comes later hears the same.
  TwoTcpLabs labs;
  labs.check_passage();
  const ChannelRules rules({{.allow = "cam_*"}, {.allow = "world"}, {.allow = "*", .direction = Direction::imports}});
  for (TcpLab* lab : {&labs.shark, &labs.roark}) {
    lab->node->set_exports(rules.announced({"roark", "shark"}));
    lab->gateway->set_rules(rules);
  }
  for (int cut = 0; cut < 2; ++cut) {
    labs.shark.publish("cam_1", "picture");
    labs.shark.publish("status", "not any more");
    labs.check_passage("after the change " + std::to_string(cut));
    // Or once more, when the cut came before the acknowledgement.
    CHECK(std::ranges::count(labs.roark.heard, std::pair<std::string, std::string>("shark/cam_1", "picture")) > cut);
    CHECK(labs.shark.count("session.opened") == static_cast<std::uint64_t>(cut + 1));
    CHECK(labs.roark.count("received.refused.unlisted_channel") == 0);
    check_accounts(labs.shark.link().stats());
    if (cut == 0) {
      labs.proxy->reset();
      REQUIRE(labs.until([&] { return labs.shark.count("session.opened") == 2 && labs.roark.up(); }));
    }
  }
}

TEST_CASE("a slow reader gets young values") {
  // Through 50 kB/s, of which 400 are offered: what waits is replaced, so that what arrives is no older than the
  // window.
  WorldOfShark world(2000, {.bytes_per_s = 50'000});
  REQUIRE(world.until([&] { return world.ages.size() >= 20; }));
  const std::size_t settled = world.ages.size();
  REQUIRE(world.until([&] { return world.ages.size() >= settled + 50; }));
  CHECK(world.oldest(settled) < 140);
  CHECK(world.labs.shark.count("outbox.replaced.world") > 50);
  CHECK(world.labs.shark.count("session.opened") == 1);
  check_accounts(world.labs.shark.link().stats());
}

TEST_CASE("after a stall nothing old is delivered") {
  // The network holds everything for twice the time after which a link is down, and then lets go: what was under way is
  // of a session that is over.
  WorldOfShark world(500);
  REQUIRE(world.until([&] { return world.ages.size() >= 50; }));
  world.labs.proxy->set({.stall = true});
  const auto begun = Wall::now();
  REQUIRE(world.until([&] { return Wall::now() - begun > 2 * short_times().silence; }));
  const std::size_t before = world.ages.size();
  world.labs.proxy->set({});
  REQUIRE(world.until([&] { return world.ages.size() >= before + 50; }));
  CHECK(world.oldest(before) < 140);
  // The link was down meanwhile, and what was on its way is counted.
  CHECK(world.labs.roark.count("session.closed.silent") >= 1);
  check_accounts(world.labs.shark.link().stats());
  check_accounts(world.labs.roark.link().stats());
}

TEST_CASE("a small message does not wait for a large one") {
  // While 300 kB need six seconds through 50 kB/s, a status goes past them.
  TwoTcpLabs labs({.bytes_per_s = 50'000});
  REQUIRE(labs.both(true));
  labs.shark.publish("world", std::string(300'000, 'x'));
  REQUIRE(labs.until([&] { return labs.proxy->counts().bytes_to_client > 20'000; }));
  labs.shark.publish("status", "urgent");
  REQUIRE(labs.until([&] { return labs.roark.heard.size() == 1; }));
  CHECK(labs.roark.heard.front().second == "urgent");
  REQUIRE(labs.until([&] { return labs.roark.heard.size() == 2; }));
  CHECK(labs.roark.heard.back().second.size() == 300'000);
}

TEST_CASE("a hundred cuts lose and repeat no ordered message") {
  // Both ways, with the connection reset at random moments while messages of all sizes flow; the accounts balance after
  // each cut.
  TwoTcpLabs labs;
  REQUIRE(labs.both(true));
  hal::RandomStream random(5, "cuts");
  std::vector<std::string> sent;
  for (std::uint64_t cut = 0; cut < 100; ++cut) {
    const auto burst = 1 + random.below(20);
    for (std::uint64_t i = 0; i < burst; ++i) {
      sent.push_back(std::to_string(sent.size()) +
                     std::string(random.below(10) == 0 ? 40'000 : random.below(300), 'x'));
      labs.shark.publish("events", sent.back());
      labs.roark.publish("events", sent.back());
    }
    auto turns = random.below(30);
    labs.until([&] { return turns-- == 0; });
    labs.proxy->reset();
    check_accounts(labs.shark.link().stats());
    check_accounts(labs.roark.link().stats());
    REQUIRE(labs.until([&] { return labs.roark.count("session.opened") > cut + 1; }));
  }
  REQUIRE(labs.until([&] { return labs.roark.heard.size() >= sent.size() && labs.shark.heard.size() >= sent.size(); }));
  for (const TcpLab* lab : {&labs.shark, &labs.roark}) {
    REQUIRE(lab->heard.size() == sent.size());
    bool equal = true;
    for (std::size_t i = 0; i < sent.size(); ++i) equal &= lab->heard[i].second == sent[i];
    CHECK(equal);
    CHECK(lab->count("received.missing.events") == 0);
  }
  REQUIRE(labs.until([&] { return labs.shark.count("outbox.acknowledged.events") == sent.size(); }));
  CHECK(labs.shark.count("received.repeated.events") + labs.roark.count("received.repeated.events") > 0);
}

TEST_CASE("a gateway that is started again leaves a gap of known size") {
  // It forgets what it had not sent; the peer knows how much that was, exactly, and says so.
  TwoTcpLabs labs({.bytes_per_s = 30'000});
  REQUIRE(labs.both(true));
  for (int i = 0; i < 50; ++i) labs.shark.publish("events", std::string(2000, 'x'));
  REQUIRE(labs.until([&] { return labs.roark.heard.size() >= 10; }));
  const auto here = labs.shark.node->listening().port();
  labs.start_shark("127.0.0.1:" + std::to_string(here));
  REQUIRE(labs.until([&] { return labs.roark.up() && labs.roark.link().stats().peer_boot_id == labs.boots; }));
  const std::size_t missing = labs.roark.count("received.missing.restart");
  CHECK(missing > 0);
  CHECK(missing + labs.roark.heard.size() == 50);
  CHECK(labs.roark.link().stats().why ==
        "connected; " + std::to_string(missing) + " ordered messages were lost when its gateway restarted");
  labs.shark.publish("events", "anew");
  CHECK(labs.until([&] { return labs.roark.heard_last("shark/events", "anew"); }));
}

TEST_CASE("a peer that is started again gets what holds") {
  // The newest value of a `latest` channel is sent to a gateway that has nothing, without being published again; not to
  // one that only lost its connection.
  TwoTcpLabs labs;
  labs.check_passage("it holds");
  REQUIRE(labs.until([&] { return labs.shark.count("outbox.acknowledged.world") == 1; }));
  labs.proxy->reset();
  REQUIRE(labs.until([&] { return labs.roark.count("session.opened") == 2; }));
  labs.roark.heard.clear();
  labs.start_roark();
  REQUIRE(labs.until([&] { return labs.roark.heard.size() == 1; }));
  CHECK(labs.roark.heard_last("shark/world", "it holds"));
  CHECK(labs.shark.count("outbox.accepted.world") == 2);
  check_accounts(labs.shark.link().stats());
}

TEST_CASE("gateways know each other's clocks") {
  // In one process both are the same clock: what is estimated is 0 within its uncertainty, on a slow path too.
  TwoTcpLabs labs({.delay = 20ms, .jitter = 20ms});
  REQUIRE(labs.until([&] { return labs.shark.link().stats().clock && labs.roark.link().stats().clock; }));
  const auto begun = Wall::now();
  REQUIRE(labs.until([&] { return Wall::now() - begun > 500ms; }));
  for (const TcpLab* lab : {&labs.shark, &labs.roark}) {
    const LinkStats stats = lab->link().stats();
    CHECK(std::abs(stats.clock->offset_us) <= stats.clock->uncertainty_us);
    CHECK(stats.clock->round_trip_us >= 40'000);
    CHECK(stats.clock->uncertainty_us >= 20'000);
    CHECK(std::abs(stats.peer_wall_offset_us) <= stats.clock->uncertainty_us + 1000);
  }
}

}  // namespace
}  // namespace arkmesh::gateway
