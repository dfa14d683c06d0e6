// The gateway between two labs of one process: names, echoes, ages and counters, over loopback links.
#include "gateway/gateway.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "arkmesh/peers_t.hpp"
#include "gateway/frame/channel_name.hpp"
#include "gateway/links/loopback.hpp"

namespace arkmesh::gateway {
namespace {

using namespace std::chrono_literals;

std::span<const std::byte> bytes_in(std::string_view text) {
  return std::as_bytes(std::span(text));
}

// A lab's bus with everything that was heard on it.
struct LabBus {
  hal::Bus bus{"memq://"};
  std::multimap<std::string, std::string> heard;
  peers_t peers;
  std::unique_ptr<hal::Bus::Subscription> all = bus.subscribe(".*", [this](std::string_view channel, auto bytes) {
    if (channel == "peers") {
      REQUIRE(hal::decode(bytes, peers));
      return;
    }
    heard.emplace(channel, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  });
};

struct TwoLabs {
  LabBus shark, roark;
  LoopbackNetwork network{1};
  std::unique_ptr<Gateway> of_shark, of_roark;

  explicit TwoLabs(const std::vector<Rule>& exports = {{"world", Delivery::latest}, {"status", Delivery::latest}},
                   bool started = true)
      : TwoLabs(ChannelRules(exports, {"world", "status", "events", "a.c"}), started) {}
  explicit TwoLabs(const ChannelRules& rules, bool started = true) {
    std::vector<std::unique_ptr<Link>> links;
    links.push_back(network.end("shark", "roark"));
    of_shark = std::make_unique<Gateway>(shark.bus, "shark", 11, rules, std::move(links));
    links.clear();
    links.push_back(network.end("roark", "shark"));
    of_roark = std::make_unique<Gateway>(roark.bus, "roark", 22, rules, std::move(links));
    if (started) start();
  }
  void start() {
    of_shark->start();
    of_roark->start();
    network.step();
  }
  void settle() {
    do {
      shark.bus.drain();
      roark.bus.drain();
    } while (network.busy() && network.step() >= 0);
    shark.bus.drain();
    roark.bus.drain();
  }
};

TEST_CASE("exported channels arrive under the sender's name") {
  // What a lab publishes on an exported channel comes to the other once, under its lab's name, and nothing comes back.
  TwoLabs labs;
  labs.shark.bus.publish("world", bytes_in("period 7"));
  labs.settle();
  CHECK(labs.roark.heard.size() == 1);
  CHECK(labs.roark.heard.find("shark/world")->second == "period 7");
  CHECK(labs.shark.heard.size() == 1);  // its own
}

TEST_CASE("what is published before the links start is kept for the peers") {
  // A gateway that still looks around loses nothing of its lab's, and nothing crosses before.
  TwoLabs labs({{"events", Delivery::ordered}}, false);
  for (const char* text : {"1", "2"}) labs.shark.bus.publish("events", bytes_in(text));
  labs.settle();
  labs.network.step();
  CHECK_FALSE(labs.of_shark->links()[0]->stats().up);
  CHECK(labs.roark.heard.empty());
  labs.start();
  labs.settle();
  CHECK(labs.roark.heard.count("shark/events") == 2);
}

TEST_CASE("other channels stay at home") {
  // Only exact names of the export list are exported: no prefix, no foreign name, no pattern character is taken as one.
  TwoLabs labs({{"world", Delivery::latest}, {"a.c", Delivery::latest}});
  for (const char* channel : {"poses", "worlds", "aworld", "lynx/world", "roark/world", "abc", "status"})
    labs.shark.bus.publish(channel, bytes_in("x"));
  labs.settle();
  CHECK(labs.roark.heard.empty());
  labs.shark.bus.publish("a.c", bytes_in("x"));
  labs.settle();
  CHECK(labs.roark.heard.count("shark/a.c") == 1);
}

TEST_CASE("what is not imported is refused and counted by channel") {
  // A peer that exports more than this lab wants, commands for robots for instance; a peer with hundreds of such
  // channels makes no hundreds of counters.
  std::vector<Rule> exports{{"world", Delivery::latest}, {"operator_command", Delivery::ordered}};
  for (int i = 0; i < 100; ++i) exports.push_back({"more" + std::to_string(i), Delivery::ordered});
  TwoLabs labs(exports);
  labs.shark.bus.publish("operator_command", bytes_in("run"));
  labs.shark.bus.publish("operator_command", bytes_in("run"));
  labs.shark.bus.publish("world", bytes_in("1"));
  for (int i = 0; i < 100; ++i) labs.shark.bus.publish("more" + std::to_string(i), bytes_in("x"));
  labs.settle();
  CHECK(labs.roark.heard.size() == 1);
  CHECK(labs.roark.heard.count("shark/world") == 1);
  labs.of_roark->tick(1s);
  labs.settle();
  std::map<std::string, std::int64_t> counters;
  for (const counter_t& each : labs.roark.peers.peers[0].counters) counters[each.name] = each.value;
  CHECK(counters["received.refused.not_imported.operator_command"] == 2);
  CHECK(counters["received.refused.not_imported"] == 85);
  CHECK(counters.size() < 40);
}

TEST_CASE("rules choose by pattern and peer") {
  // A pattern exports what it means, but neither foreign names, nor commands to robots, nor what is too long to cross;
  // an earlier denial counts first; what a peer sends comes out below the peer's name.
  using enum Direction;
  std::vector<ChannelRule> all{{.deny = "cam_2", .direction = exports},
                               {.allow = "tally", .direction = exports},
                               {.allow = "*", .direction = exports, .peers = {"roark"}},
                               {.allow = "*", .direction = imports}};
  TwoLabs labs{ChannelRules(all)};
  for (const char* channel : {"cam_1", "cam_2", "tally", "operator_command", "to_robots", "roark/x"})
    labs.shark.bus.publish(channel, bytes_in(channel));
  labs.shark.bus.publish(std::string(48, 'x'), bytes_in("x"));
  labs.roark.bus.publish("cam_1", bytes_in("the rule is not about lab shark"));
  labs.settle();
  CHECK(labs.roark.heard == std::multimap<std::string, std::string>{{"cam_1", "the rule is not about lab shark"},
                                                                    {"shark/cam_1", "cam_1"},
                                                                    {"shark/tally", "tally"}});
  CHECK(labs.shark.heard.count("roark/cam_1") == 0);
  CHECK(labs.of_shark->counters()["sent.refused.channel_name"] == 1);
}

TEST_CASE("a peer that publishes more than it may is held to it") {
  // Ten seconds of 50 messages each: at 5 Hz and 100 bytes a second, and a second's worth at once in the beginning.
  // What is refused is counted by reason and channel; a channel within its limits is not held back by one that is
  // beyond.
  std::vector<ChannelRule> all{{.allow = "*"},
                               {.allow = "fast", .direction = Direction::imports, .rate_hz = 5},
                               {.allow = "fat", .direction = Direction::imports, .bytes_per_s = 100},
                               {.allow = "*", .direction = Direction::imports}};
  TwoLabs labs{ChannelRules(all)};
  const std::string forty(40, 'x'), thousand(1000, 'x');
  for (int tick = 0; tick < 100; ++tick) {
    labs.of_roark->tick(tick * 100ms);
    for (int i = 0; i < 5; ++i)
      for (const auto& [channel, text] : {std::pair("fast", &forty), std::pair("fat", &forty)})
        labs.shark.bus.publish(channel, bytes_in(*text));
    labs.shark.bus.publish("free", bytes_in(thousand));
    labs.settle();
  }
  const auto fast = labs.roark.heard.count("shark/fast"), fat = labs.roark.heard.count("shark/fat");
  CHECK(fast == 54);  // 5, and 5 a second for 9.9 s
  CHECK(fat == 27);   // 2, and 2.5 a second
  CHECK(labs.roark.heard.count("shark/free") == 100);
  labs.of_roark->announce();
  labs.of_roark->tick(10s);
  labs.settle();
  std::map<std::string, std::int64_t> counters;
  for (const counter_t& each : labs.roark.peers.peers[0].counters) counters[each.name] = each.value;
  CHECK(counters["received.refused.rate_limited.fast"] == 500 - 54);
  CHECK(counters["received.refused.over_budget.fat"] == 500 - 27);
}

TEST_CASE("a peer is held to what it may publish in all") {
  // Two channels, each within its own limits, share the peer's; one message of more than a second's worth passes when
  // nothing was used before, and is paid off by those after it.
  ChannelRules rules({{.allow = "*"}, {.allow = "*", .direction = Direction::imports}});
  rules.limit("shark", {.rate_hz = 10, .bytes_per_s = 500});
  TwoLabs labs{rules};
  labs.shark.bus.publish("fat", bytes_in(std::string(2000, 'x')));
  for (int tick = 0; tick <= 30; ++tick) {
    labs.of_roark->tick(tick * 100ms);
    labs.shark.bus.publish("a", bytes_in("x"));
    labs.settle();
  }
  CHECK(labs.roark.heard.count("shark/fat") == 1);
  CHECK(labs.roark.heard.count("shark/a") == 0);  // the debt is paid after 3 s
  for (int tick = 40; tick < 50; ++tick) {
    labs.of_roark->tick(tick * 100ms);
    for (const char* channel : {"a", "b", "a", "b"}) labs.shark.bus.publish(channel, bytes_in("x"));
    labs.settle();
  }
  CHECK(labs.roark.heard.count("shark/a") + labs.roark.heard.count("shark/b") == 10 + 9);
  labs.of_roark->announce();
  labs.of_roark->tick(10s);
  labs.settle();
  std::map<std::string, std::int64_t> counters;
  for (const counter_t& each : labs.roark.peers.peers[0].counters) counters[each.name] = each.value;
  CHECK(counters["received.refused.peer_over_budget.a"] == 31);
  CHECK(counters["received.refused.peer_rate_limited.a"] + counters["received.refused.peer_rate_limited.b"] == 21);
}

TEST_CASE("rules change at work") {
  // What is allowed from now on passes, what is not does not; limits are the new ones. What waited for the peer under
  // a name that it does not get any more is dropped, not sent.
  using enum Direction;
  TwoLabs labs({{"world", Delivery::latest}, {"events", Delivery::ordered}}, false);
  for (const char* channel : {"world", "events"}) labs.shark.bus.publish(channel, bytes_in("old"));
  labs.settle();
  labs.of_shark->set_rules(ChannelRules({{.allow = "world"}, {.allow = "cam_*"}}));
  labs.of_roark->set_rules(ChannelRules({{.allow = "*", .direction = imports, .rate_hz = 2}}));
  labs.start();
  labs.network.step();
  for (const char* channel : {"world", "events", "cam_1"}) labs.shark.bus.publish(channel, bytes_in("new"));
  labs.settle();
  CHECK(labs.roark.heard == std::multimap<std::string, std::string>{
                                {"shark/cam_1", "new"}, {"shark/world", "old"}, {"shark/world", "new"}});
  CHECK(labs.of_shark->links()[0]->stats().counters["outbox.dropped.denied.events"] == 1);
  labs.shark.bus.publish("world", bytes_in("third"));
  labs.settle();
  CHECK(labs.roark.heard.count("shark/world") == 2);
  labs.of_roark->set_rules(ChannelRules({{.allow = "world", .direction = imports}}));
  for (const char* channel : {"world", "cam_1"}) labs.shark.bus.publish(channel, bytes_in("newest"));
  labs.settle();
  CHECK(labs.roark.heard.count("shark/world") == 3);
  CHECK(labs.roark.heard.count("shark/cam_1") == 1);
}

TEST_CASE("a bus with very many names makes no gateway grow") {
  // The 257th name that a pattern means is refused and counted; those before still cross.
  TwoLabs labs{ChannelRules({{.allow = "*"}, {.allow = "*", .direction = Direction::imports}})};
  for (int i = 0; i < 300; ++i) labs.shark.bus.publish("c" + std::to_string(i), bytes_in("x"));
  labs.shark.bus.publish("c0", bytes_in("y"));
  labs.settle();
  CHECK(labs.roark.heard.size() == 257);
  CHECK(labs.roark.heard.count("shark/c0") == 2);
  CHECK(labs.of_shark->counters()["sent.refused.too_many_channels"] == 44);
}

TEST_CASE("peers tells link, ages and counters") {
  // `peers` is published at each change and once a second, with ages against the caller's time and counts of what came.
  TwoLabs labs;
  CHECK(labs.of_roark->tick(0s));  // the link has come up
  labs.settle();
  REQUIRE(labs.roark.peers.n_peers == 1);
  CHECK(labs.roark.peers.lab == "roark");
  CHECK(labs.roark.peers.boot_id == 22);
  CHECK(labs.roark.peers.peers[0].lab == "shark");
  CHECK(labs.roark.peers.peers[0].up == 1);
  CHECK(labs.roark.peers.peers[0].n_channels == 0);

  labs.shark.bus.publish("world", bytes_in("12345"));
  labs.shark.bus.publish("world", bytes_in("67890"));
  labs.settle();
  CHECK_FALSE(labs.of_roark->tick(500ms));
  CHECK(labs.of_roark->tick(1s));
  labs.settle();
  REQUIRE(labs.roark.peers.peers[0].n_channels == 1);
  const channel_age_t& age = labs.roark.peers.peers[0].channels[0];
  CHECK(age.channel == "shark/world");
  CHECK(age.messages == 2);
  CHECK(age.bytes == 10);
  CHECK(age.age_us == 500'000);

  labs.network.set_up("shark", "roark", false);
  CHECK(labs.of_roark->tick(1100ms));
  CHECK_FALSE(labs.of_roark->tick(1200ms));
  labs.of_roark->announce();
  hal::Counters more;
  more.add("process.something", 3);
  CHECK(labs.of_roark->tick(1300ms, more));
  labs.settle();
  CHECK(labs.roark.peers.peers[0].up == 0);
  CHECK(labs.roark.peers.peers[0].why == "link down");
  bool found = false;
  for (const counter_t& counter : labs.roark.peers.counters)
    found |= counter.name == "process.something" && counter.value == 3;
  CHECK(found);
}

TEST_CASE("no event after the gateway is gone") {
  // A destroyed gateway neither hears its bus nor its links.
  TwoLabs labs;
  labs.of_roark.reset();
  labs.shark.bus.publish("world", bytes_in("x"));
  labs.roark.bus.publish("world", bytes_in("x"));
  labs.settle();
  labs.network.step();
  labs.settle();
  CHECK(labs.roark.heard.size() == 1);  // its own
  CHECK(labs.shark.heard.size() == 1);
  CHECK_FALSE(labs.of_shark->links()[0]->stats().up);
}

TEST_CASE("names that may cross") {
  // The table of channel names: what is legal abroad, what it is called there, which pattern matches it alone.
  for (const char* good : {"world", "a", "a.b-c_d", "WORLD", "x[1]"}) CHECK(is_exported_name(good));
  for (const char* bad : {"", "roark/world", "/", "two words", "tab\t", "umlaut\xc3\xa4"})
    CHECK_FALSE(is_exported_name(bad));
  CHECK(is_exported_name(std::string(47, 'c')));
  CHECK_FALSE(is_exported_name(std::string(48, 'c')));
  CHECK(foreign_name("roark", "world") == "roark/world");
  CHECK(lcm_pattern("world_2") == "world_2");
  CHECK(lcm_pattern("a.b") == "a\\.b");
}

}  // namespace
}  // namespace arkmesh::gateway
