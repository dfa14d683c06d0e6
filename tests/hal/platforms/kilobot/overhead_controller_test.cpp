// What goes to the overhead controller and when, in time that the tests move.
#include "hal/platforms/kilobot/overhead_controller.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <string>

#include "hal/config/config.hpp"
#include "tests/hal/platforms/kilobot/overhead_bench.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

using Kind = hal::FleetCommand::Kind;

// No two packets in a row are equal, and no two begin closer to each other than `spacing`, stops excepted.
void check_order(const std::vector<FakeCable::Heard>& heard, std::chrono::microseconds spacing) {
  for (std::size_t i = 1; i < heard.size(); ++i) {
    CAPTURE(i);
    CHECK(heard[i].packet != heard[i - 1].packet);
    CHECK(heard[i].at - heard[i - 1].at >= (heard[i - 1].type() == PacketType::stop ? stop_spacing : spacing));
  }
}

}  // namespace

TEST_CASE("overhead controller: start") {
  // A controller that starts when its port opens is left alone until it listens; then it is told to stop whatever it
  // did.
  OverheadBench bench;
  bench.controller.command({Kind::run});
  bench.run(2500ms);
  CHECK(bench.cable->heard.empty());
  bench.run(100ms);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 2);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(heard[0].at - TimePoint{} == 2500ms);
  CHECK(heard[1].message_type() == type_run);
}

TEST_CASE("overhead controller: spacing") {
  // Composites for a large swarm leave the setting's time for their copies on the air, and use all of the airtime.
  for (const bool once : {false, true}) {
    CAPTURE(once);
    OverheadBench bench(100, {.spacing = once ? 42ms : 55ms, .once = once});
    bench.start();
    std::uint16_t value = 0;
    bench.run(11s, [&] {
      if (bench.now.time_since_epoch() % 100ms != 0ms) return;
      ++value;
      for (hal::RobotId robot = 0; robot < 100; ++robot) bench.offer(robot, 0, 1, value);
    });
    const auto heard = bench.cable->take();
    check_order(heard, bench.settings.spacing);
    CHECK(heard.size() >= 11s / bench.settings.spacing - 1);
    std::map<hal::RobotId, int> times;
    for (const auto& one : heard) {
      CHECK(one.type() == (once ? PacketType::forward_once : PacketType::forward));
      for (const hal::RobotId robot : robots_of(one.packet)) ++times[robot];
    }
    // fair: nobody is a round ahead of anybody
    CHECK(times.size() == 100);
    const auto [least, most] = std::ranges::minmax_element(times, {}, [](const auto& entry) { return entry.second; });
    CHECK(most->second - least->second <= 1);
  }
}

TEST_CASE("overhead controller: silence") {
  // Each message is sent once for its spacing, then one stop, then nothing: the channel belongs to the robots.
  OverheadBench bench;
  bench.start();
  bench.offer(3);
  bench.run(5s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 2);
  CHECK(robots_of(heard[0].packet) == std::vector<hal::RobotId>{3});
  CHECK(heard[1].type() == PacketType::stop);
  CHECK(heard[1].at - heard[0].at == 55ms);
  CHECK(bench.controller.is_silent(bench.now));

  // a message that is sent once needs no stop
  OverheadBench once(10, {.once = true});
  once.start();
  once.offer(3);
  once.run(5s);
  CHECK(once.cable->take().size() == 1);
}

TEST_CASE("overhead controller: fleet commands") {
  // Commands overtake all registers, are repeated by the controller for their time, keep their order, and end with a
  // stop.
  OverheadBench bench;
  bench.start();
  for (hal::RobotId robot = 0; robot < 9; ++robot) bench.offer(robot);
  bench.controller.command({Kind::reset});
  bench.controller.command({Kind::run});
  bench.controller.command({Kind::broadcast, 120, {1, 2, 3}});
  bench.run(3s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 7);
  CHECK(heard[0].message_type() == type_reset);
  CHECK(heard[1].message_type() == type_run);
  CHECK(heard[1].at - heard[0].at == 500ms);
  CHECK(heard[2].message_type() == 120);
  CHECK(heard[2].packet[4] == 3);
  CHECK(heard[2].at - heard[1].at == 500ms);
  CHECK(heard[3].at - heard[2].at == 200ms);
  for (int i : {3, 4, 5}) CHECK(robots_of(heard[static_cast<std::size_t>(i)].packet).size() == 3);
  CHECK(heard[6].type() == PacketType::stop);
  CHECK(bench.counters["fleet_command.sent"] == 3);
}

TEST_CASE("overhead controller: robots asleep") {
  // Robots asleep listen every 8 s, so the command after `sleep` is repeated for longer than that.
  OverheadBench bench;
  bench.start();
  bench.controller.command({Kind::sleep});
  bench.run(1s);
  bench.controller.command({Kind::pause});
  bench.run(100ms);
  bench.controller.command({Kind::run});
  bench.run(12s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 5);
  CHECK(heard[0].message_type() == type_sleep);
  CHECK(heard[2].message_type() == type_wakeup);
  CHECK(heard[3].message_type() == type_run);
  CHECK(heard[3].at - heard[2].at == 10s);
  CHECK(heard[4].at - heard[3].at == 500ms);
}

TEST_CASE("overhead controller: what robots should do is a register") {
  // Of quick words the last one is said, and none is thrown away for want of room; a word that stands is not said
  // twice.
  OverheadBench bench;
  bench.start();
  for (int i = 0; i < 500; ++i) {
    bench.controller.command({Kind::pause});
    bench.controller.command({Kind::run});
    bench.controller.command({Kind::run});
  }
  bench.run(5s);
  auto heard = bench.cable->take();
  REQUIRE(heard.size() == 2);
  CHECK(heard[0].message_type() == type_run);
  CHECK(bench.counters["fleet_command.refused.too_many"] == 0);
  CHECK(bench.counters["fleet_command.replaced"] == 999);

  // Presses at any rate: the pause that is wanted in the end is on the air at once, whole.
  for (int i = 0; i < 40; ++i) {
    bench.controller.command({i % 2 == 0 ? Kind::run : Kind::pause});
    bench.run(13ms);
  }
  bench.run(600ms);
  heard = bench.cable->take();
  REQUIRE(heard.size() >= 2);
  const auto last = std::find_if(heard.rbegin(), heard.rend(), [](const auto& one) {
    return one.message_type() == type_wakeup || one.message_type() == type_run;
  });
  REQUIRE(last != heard.rend());
  CHECK(last->message_type() == type_wakeup);
  CHECK(bench.controller.said_since().has_value());
}

TEST_CASE("overhead controller: a pause stands for as long as it is wanted") {
  // It is said again every few seconds, other words are not; and at once and at length when somebody was seen to walk.
  OverheadBench bench;
  bench.start();
  bench.controller.command({Kind::pause});
  CHECK_FALSE(bench.controller.said_since());
  bench.run(60s);
  CHECK(bench.controller.said_since());
  const auto pauses = [&] {
    const auto heard = bench.cable->take();
    return std::ranges::count_if(heard, [](const auto& one) { return one.message_type() == type_wakeup; });
  };
  CHECK(pauses() >= 15);
  bench.controller.urge(bench.now);
  bench.run(600ms);
  CHECK(pauses() == 1);
  for (const Kind other : {Kind::run, Kind::sleep, Kind::voltage, Kind::charge}) {
    bench.controller.command({other});
    bench.run(30s);
    CHECK(pauses() == 0);
    CHECK(bench.counters["fleet_command.sent"] > 0);
  }
}

TEST_CASE("overhead controller: what makes robots stand overtakes everything") {
  // A word that lets robots walk, and a long broadcast, are cut for it; rules that were said before `run` are heard
  // before.
  for (const hal::FleetCommand& before : {hal::FleetCommand{Kind::run}, hal::FleetCommand{Kind::broadcast, 9, {1}}}) {
    OverheadBench bench(100, {.broadcast_for = 20s});
    bench.start();
    bench.controller.command(before);
    bench.run(200ms);
    bench.controller.command({Kind::broadcast, 10, {1}});
    bench.controller.command({Kind::pause});
    bench.run(60ms);
    const auto heard = bench.cable->take();
    CHECK(heard.back().message_type() == type_wakeup);
    CHECK(bench.counters["fleet_command.cut_short"] == 1);
  }
  OverheadBench bench;
  bench.start();
  bench.controller.command({Kind::broadcast, 9, {1}});
  bench.controller.command({Kind::run});
  bench.run(1s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 3);
  CHECK(heard[0].message_type() == 9);
  CHECK(heard[1].message_type() == type_run);
}

TEST_CASE("overhead controller: refused commands") {
  // A broadcast of a type that robots' libraries keep for themselves is refused, and so is a flood; both are counted.
  OverheadBench bench;
  bench.controller.command({Kind::broadcast, 128, {}});
  CHECK(bench.counters["fleet_command.refused.type"] == 1);
  for (int i = 0; i < 100; ++i) bench.controller.command({Kind::broadcast, 9, {1}});
  CHECK(bench.counters["fleet_command.refused.too_many"] == 36);
}

TEST_CASE("overhead controller: dangerous neighbours") {
  // Messages full of header bytes never make the controller hear anything but what was meant, repeated or sent once.
  for (const bool once : {false, true}) {
    OverheadBench bench(400, {.once = once});
    bench.start();
    // robot 341 = 0x155, kind 5, value 0x155 packs into 0x55 0x55 0x55 bytes
    std::uint64_t offered = 0;
    bench.run(30s, [&] {
      bench.offer(341, 0, 5, 0x155);
      bench.offer(340, 0, 1, static_cast<std::uint16_t>(0x54 + offered++ % 3));
    });
    std::uint64_t composites = 0;
    const auto heard = bench.cable->take();
    for (const auto& one : heard) {
      CHECK((one.type() == PacketType::stop || one.type() == (once ? PacketType::forward_once : PacketType::forward)));
      CHECK(one.message_type() == 0);
      if (one.type() == PacketType::stop) continue;
      ++composites;
      CHECK(std::ranges::count(robots_of(one.packet), 341U) == 1);
    }
    check_order(heard, bench.settings.spacing);
    // nothing beside what was sent was heard
    CHECK(heard.size() + 1 == bench.counters["overhead.packets"]);
    CHECK(bench.counters["overhead.parting_stops"] > 10);
    CHECK(composites > 250);
  }
}

TEST_CASE("overhead controller: a standing question") {
  // A question is repeated by the controller while nobody has messages, takes every second packet when somebody has,
  // and ends with a stop.
  OverheadBench bench;
  bench.start();
  Message question{{7}, 120, 0};
  bench.controller.ask(question);
  bench.run(1s);
  auto heard = bench.cable->take();
  REQUIRE(heard.size() == 1);
  CHECK(heard[0].message_type() == 120);

  std::uint16_t value = 0;
  bench.run(2200ms, [&] { bench.offer(1, 0, 1, ++value % 512); });
  heard = bench.cable->take();
  check_order(heard, bench.settings.spacing);
  CHECK(std::ranges::count(heard, 120, &FakeCable::Heard::message_type) >= 18);
  CHECK(std::ranges::count(heard, 0, &FakeCable::Heard::message_type) >= 18);

  // another one follows as soon as the last packet has had its time
  bench.run(200ms);
  question.data[0] = 8;
  bench.cable->take();
  bench.controller.ask(question);
  bench.run(5ms);
  heard = bench.cable->take();
  REQUIRE(heard.size() == 1);
  CHECK(heard[0].packet[2] == 8);

  bench.controller.ask({});
  bench.run(1s);
  heard = bench.cable->take();
  REQUIRE(heard.size() == 1);
  CHECK(heard[0].type() == PacketType::stop);
}

TEST_CASE("overhead controller: on hold") {
  // Before an experiment begins only questions go out, however long that takes; what was said meanwhile comes
  // afterwards, whole.
  OverheadBench bench;
  bench.controller.hold(true);
  bench.start();
  bench.controller.command({Kind::run});
  bench.offer(3);
  bench.controller.ask(Message{.type = 100});
  bench.run(20s);
  for (const auto& heard : bench.cable->take()) CHECK(heard.message_type() == 100);
  // what makes robots stand does not wait
  bench.controller.command({Kind::pause});
  bench.run(200ms);
  CHECK(bench.cable->take().front().message_type() == type_wakeup);
  bench.controller.command({Kind::run});
  bench.run(20s);
  for (const auto& heard : bench.cable->take()) CHECK(heard.message_type() != type_run);
  bench.controller.ask({});
  bench.controller.hold(false);
  bench.run(1s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() >= 2);
  CHECK(std::ranges::any_of(heard, [](const auto& each) { return each.message_type() == type_run; }));
  CHECK(std::ranges::any_of(heard,
                            [](const auto& each) { return robots_of(each.packet) == std::vector<hal::RobotId>{3}; }));
  CHECK(bench.counters["fleet_command.expired"] == 0);
}

TEST_CASE("overhead controller: a command during a question") {
  // A fleet command interrupts a question, which is taken up again afterwards.
  OverheadBench bench;
  bench.start();
  bench.controller.ask(Message{{7}, 119, 0});
  bench.run(500ms);
  bench.controller.command({Kind::run});
  bench.run(1s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 3);
  CHECK(heard[1].message_type() == type_run);
  CHECK(heard[2].message_type() == 119);
  CHECK(heard[2].at - heard[1].at == 500ms);
}

TEST_CASE("overhead controller: doubtful robots") {
  // Nothing is said to a robot whose name is in doubt: what waits is dropped, what is on the air ends, new offers are
  // dropped; the others get theirs, and the totals add up.
  OverheadBench bench;
  bench.start();
  for (hal::RobotId robot : {1, 2, 3, 4}) bench.offer(robot, 0), bench.offer(robot, 1);
  bench.run(1ms);
  auto heard = bench.cable->take();
  REQUIRE(heard.size() == 1);
  CHECK(robots_of(heard[0].packet) == std::vector<hal::RobotId>{1, 2, 3});
  const std::vector<hal::RobotId> doubtful{2, 4};
  bench.controller.withhold(doubtful, bench.now);
  bench.offer(2, 2), bench.offer(5, 0);
  bench.run(2s);
  const auto later = bench.cable->take();
  REQUIRE(!later.empty());
  CHECK(later[0].at - heard[0].at == 40ms);
  for (const auto& one : later)
    for (const hal::RobotId robot : robots_of(one.packet)) CHECK((robot == 1 || robot == 3 || robot == 5));
  CHECK(bench.counters["to_robots.withheld.doubtful"] == 4);
  CHECK(bench.controller.not_heard().words == std::set<hal::RobotId>{2, 4});
  const hal::Airtime airtime = bench.controller.airtime();
  CHECK(airtime.offered == 10);
  CHECK(airtime.sent == 6);
  CHECK(airtime.not_sent == 4);
  CHECK(airtime.waiting == 0);

  bench.controller.withhold({}, bench.now);
  bench.offer(2);
  bench.run(1s);
  CHECK(robots_of(bench.cable->take().at(0).packet) == std::vector<hal::RobotId>{2});
}

TEST_CASE("overhead controller: a composite that had to wait") {
  // A robot that falls into doubt while its composite waits for a parting stop is taken out of that composite.
  OverheadBench bench(400);
  bench.start();
  bench.offer(341, 0, 5, 0x155), bench.offer(340, 0, 1, 0x55), bench.offer(5);
  bench.run(55ms);
  bench.offer(341, 0, 5, 0x155), bench.offer(340, 0, 1, 0x54), bench.offer(5);
  bench.run(1ms);
  REQUIRE(bench.cable->take().back().type() == PacketType::stop);
  REQUIRE(bench.counters["overhead.parting_stops"] == 1);
  bench.controller.withhold(std::vector<hal::RobotId>{340}, bench.now);
  bench.run(500ms);
  CHECK(robots_of(bench.cable->take().at(0).packet) == std::vector<hal::RobotId>{5, 341});
}

TEST_CASE("overhead controller: the end") {
  // Towards the end fleet commands still go out, nothing else; at the end what is on the air is ended too, and the last
  // word is a stop.
  OverheadBench bench;
  bench.start();
  for (hal::RobotId robot = 0; robot < 9; ++robot) bench.offer(robot);
  bench.controller.ask(Message{{7}, 120, 0});
  bench.controller.command({Kind::run});
  bench.run(10ms);
  bench.controller.command({Kind::pause});
  bench.controller.command({Kind::broadcast, 9, {1}});
  bench.controller.command({Kind::broadcast, 10, {1}});
  bench.controller.finish();
  bench.run(600ms);
  auto heard = bench.cable->take();
  REQUIRE(heard.size() == 3);
  CHECK(heard[1].message_type() == type_wakeup);
  CHECK(heard[2].message_type() == 9);
  bench.controller.stop_sending(bench.now);
  bench.run(100ms);
  heard = bench.cable->take();
  REQUIRE(heard.size() == 1);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(bench.controller.is_silent(bench.now));
  CHECK(bench.counters["fleet_command.expired"] == 1);
}

TEST_CASE("overhead controller: settings") {
  // Every key is read in its unit, and a spacing that does not reach the air is refused with the reason.
  const auto read = [](const std::string& keys) {
    return hal::Config::from_text("[k]\n" + keys, "lab.toml").root().section("k").read<OverheadSettings>();
  };
  const OverheadSettings some =
      read("spacing_s = 0.06\ncommand_s = 1\nbroadcast_s = 0.3\nwaking_s = 9\nexpire_s = 2\nsettle_s = 0\n");
  CHECK(some.spacing == 60ms);
  CHECK(some.command_for == 1s);
  CHECK(some.broadcast_for == 300ms);
  CHECK(some.waking_for == 9s);
  CHECK(some.expire_after == 2s);
  CHECK(some.settle == 0s);
  CHECK(read("once = true\nspacing_s = 0.04").spacing == 40ms);
  CHECK_THROWS_AS(read("spacing_s = 0.045"), hal::ConfigError);
  CHECK_THROWS_AS(read("once = true\nspacing_s = 0.03"), hal::ConfigError);
}
