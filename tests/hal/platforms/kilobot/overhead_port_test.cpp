// What the overhead controller does when its line is lost, slow or takes bytes without delivering them.
#include <doctest/doctest.h>

#include "hal/platforms/kilobot/overhead_controller.hpp"
#include "tests/hal/platforms/kilobot/overhead_bench.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;
using Kind = hal::FleetCommand::Kind;

TEST_CASE("overhead controller: unplugged for long") {
  // What waited too long while the line was down is dropped and counted; nothing comes in a burst when it is back.
  OverheadBench bench;
  bench.start();
  bench.cable->plugged = false;
  bench.controller.command({Kind::run});
  bench.controller.command({Kind::broadcast, 9, {1}});
  for (int i = 0; i < 100; ++i) {
    bench.offer(static_cast<hal::RobotId>(i % 10));
    bench.run(100ms);
  }
  CHECK(bench.counters["fleet_command.expired"] == 1);
  CHECK(bench.counters["to_robots.expired"] > 0);
  CHECK(bench.counters["overhead.port_lost"] == 1);
  bench.controller.command({Kind::voltage});
  CHECK(bench.controller.airtime().waiting <= 1);
  bench.cable->plugged = true;
  bench.run(6s);
  const auto heard = bench.cable->take();
  CHECK(bench.counters["overhead.port_opened"] == 2);
  REQUIRE(heard.size() >= 2);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(heard[1].message_type() == type_voltage);
  CHECK(heard.size() <= 5);
  for (const auto& one : heard) CHECK(one.message_type() != type_run);
  const hal::Airtime airtime = bench.controller.airtime();
  CHECK(airtime.offered == airtime.sent + airtime.replaced + airtime.not_sent + airtime.waiting);
}

TEST_CASE("overhead controller: unplugged before the first run") {
  // However long that was, robots hear what they have to know before they run.
  OverheadBench bench;
  bench.start();
  bench.cable->plugged = false;
  bench.run(100ms);
  bench.controller.command({Kind::broadcast, 10, {1}});
  bench.controller.command({Kind::run});
  bench.controller.command({Kind::broadcast, 9, {1}});
  bench.run(60s);
  CHECK(bench.counters["fleet_command.expired"] == 1);
  bench.cable->plugged = true;
  bench.run(6s);
  std::vector<int> types;
  for (const auto& one : bench.cable->take())
    if (one.type() != PacketType::stop) types.push_back(one.message_type());
  CHECK(types == std::vector<int>{10, type_run});
}

TEST_CASE("overhead controller: unplugged for a moment") {
  // A reset that was on the air when the line was lost is repeated when it is back, and a question stands again; what
  // robots should do is said first.
  OverheadBench bench;
  bench.start();
  bench.controller.ask(Message{{7}, 120, 0});
  bench.controller.command({Kind::run});
  bench.run(1s);
  bench.controller.command({Kind::broadcast, 9, {1}});
  bench.run(100ms);
  bench.cable->plugged = false;
  bench.run(100ms);
  bench.cable->plugged = true;
  bench.cable->take();
  bench.run(5s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 4);
  CHECK(heard[0].type() == PacketType::stop);
  CHECK(heard[1].message_type() == type_run);
  CHECK(heard[2].message_type() == 9);
  CHECK(heard[2].at - heard[1].at == 500ms);
  CHECK(heard[3].message_type() == 120);
  CHECK(bench.counters["fleet_command.repeated_after_loss"] == 1);
}

TEST_CASE("overhead controller: a pause while the line is away") {
  // However long that was, it is said right after the controller listens again, and never what it replaced.
  for (const auto away : {3s, 8s, 30s, 600s}) {
    OverheadBench bench;
    bench.start();
    bench.controller.command({Kind::run});
    bench.run(1s);
    bench.cable->plugged = false;
    bench.run(1s);
    bench.controller.command({Kind::pause});
    bench.run(away);
    bench.cable->take();
    bench.cable->plugged = true;
    bench.run(250ms + 2500ms + 100ms);
    const auto heard = bench.cable->take();
    REQUIRE(heard.size() >= 2);
    CHECK(heard[1].message_type() == type_wakeup);
    bench.run(20s);
    for (const auto& one : bench.cable->take()) CHECK(one.message_type() != type_run);
  }
}

TEST_CASE(
    "overhead controller: what was given up is told once, and run comes behind what robots are to hear before it") {
  // What its owner says anew after an opening, in the time that a controller takes to start, goes ahead of the `run`
  // that stands, and none goes out before.
  OverheadBench bench;
  bench.start();
  bench.controller.command({Kind::run});
  bench.run(1s);
  CHECK(bench.controller.not_heard().openings == 1);
  bench.cable->plugged = false;
  bench.run(1s);
  bench.controller.command({Kind::broadcast, 10, {1}});
  bench.offer(3);
  CHECK(bench.controller.not_heard().broadcasts.empty());
  bench.run(8s);
  const hal::NotHeard lost = bench.controller.not_heard(), again = bench.controller.not_heard();
  CHECK(lost.broadcasts == std::set<std::uint8_t>{10});
  CHECK(lost.words == std::set<hal::RobotId>{3});
  CHECK(lost.restarted.empty());
  CHECK(again.openings == 1);
  CHECK((again.broadcasts.empty() && again.words.empty()));
  bench.cable->take();
  bench.cable->plugged = true;
  bench.run(500ms);
  CHECK(bench.controller.not_heard().openings == 2);
  bench.controller.command({Kind::broadcast, 10, {1}});
  bench.controller.command({Kind::run});
  bench.run(6s);
  std::vector<int> types;
  for (const auto& one : bench.cable->take())
    if (one.type() != PacketType::stop) types.push_back(one.message_type());
  CHECK(types == std::vector<int>{10, type_run});
  CHECK(bench.counters["fleet_command.replaced"] == 0);
}

TEST_CASE("overhead controller: a slow line") {
  // A packet that the system takes byte by byte arrives whole, and its time on the air begins when it has arrived.
  OverheadBench bench;
  bench.start();
  bench.cable->bytes_a_write = 3;
  for (hal::RobotId robot = 0; robot < 9; ++robot) bench.offer(robot);
  bench.run(1s);
  const auto heard = bench.cable->take();
  REQUIRE(heard.size() == 4);
  // 132 bytes take 44 ms; the air is clean for as long as after a fast packet, then the next one begins
  CHECK(heard[1].at - heard[0].at >= 55ms - packet_on_line + 43ms);
  CHECK(heard[1].at - heard[0].at <= 70ms);
}

TEST_CASE("overhead controller: a line that takes bytes and does not deliver them") {
  // Packets are not piled up in buffers from which they would come in a burst: what waits is a few packets at most.
  OverheadBench bench;
  bench.start();
  bench.cable->waiting = 5 * packet_bytes;
  bench.offer(1);
  bench.run(2s);
  CHECK(bench.cable->take().empty());
  bench.cable->waiting = 0;
  bench.run(100ms);
  CHECK(bench.cable->take().size() == 2);
}

TEST_CASE("overhead controller: somebody else paused the robots") {
  // A word that stands is said when the line is back, but behind a pause: once, and in any state of the line.
  for (const auto kind : {hal::FleetCommand::Kind::run, hal::FleetCommand::Kind::sleep}) {
    OverheadBench bench;
    bench.start();
    bench.controller.command({.kind = kind});
    bench.run(2s);
    bench.cable->take();
    for (const bool paused : {true, false}) {
      CAPTURE(paused);
      if (paused) bench.controller.pause_first();
      bench.cable->plugged = false;
      bench.run(1s);
      bench.cable->plugged = true;
      bench.run(bench.settings.settle + 3s);
      std::vector<std::uint8_t> words;
      for (const auto& heard : bench.cable->take())
        if (heard.type() == PacketType::forward && (words.empty() || words.back() != heard.message_type()))
          words.push_back(heard.message_type());
      const std::uint8_t own = kind == hal::FleetCommand::Kind::run ? type_run : type_sleep;
      const bool first = paused && kind == hal::FleetCommand::Kind::run;
      CHECK(words == (first ? std::vector<std::uint8_t>{type_wakeup, own} : std::vector<std::uint8_t>{own}));
    }
  }
}

TEST_CASE("overhead controller: a connection that was opened after the pause was said is not doubted") {
  OverheadBench bench;
  bench.cable->connects = true;
  bench.start();
  bench.controller.command({Kind::run});
  bench.run(1s);
  bench.controller.command({Kind::pause});
  bench.run(1s);
  bench.cable->plugged = false;
  bench.run(1s);
  bench.cable->plugged = true;
  for (int look = 0; look < 50; ++look) {
    bench.controller.doubt_line();
    bench.run(100ms);
  }
  CHECK(bench.counters["overhead.port_opened"] == 2);
  CHECK(bench.counters["overhead.connection_reset"] == 0);
}

TEST_CASE("overhead controller: a connection that seems to hold back a pause is given up for another") {
  // Once for each word, and the new one begins with a stop and the pause at once; a serial line is kept, and so is a
  // connection while no pause was said.
  for (const bool connects : {true, false}) {
    CAPTURE(connects);
    OverheadBench bench;
    bench.cable->connects = connects;
    bench.start();
    for (std::uint64_t word = 1; word <= 2; ++word) {
      bench.controller.command({Kind::run});
      bench.run(1s);
      bench.controller.doubt_line();
      bench.controller.command({Kind::pause});
      bench.run(1s);
      bench.cable->take();
      for (int look = 0; look < 3; ++look) {
        bench.controller.urge(bench.now);
        bench.controller.doubt_line();
        bench.run(100ms);
      }
      const auto heard = bench.cable->take();
      CHECK(bench.counters["overhead.connection_reset"] == (connects ? word : 0));
      CHECK(bench.counters["overhead.port_opened"] == (connects ? 1 + word : 1));
      if (!connects) continue;
      REQUIRE(heard.size() >= 2);
      CHECK(heard[0].type() == PacketType::stop);
      CHECK(heard[1].message_type() == type_wakeup);
      // and stays on the air while they walk, said anew behind a stop, until they were seen to stand
      bench.run(6s, [&] { bench.controller.urge(bench.now); });
      const auto later = bench.cable->take();
      REQUIRE(later.size() >= 6);
      for (std::size_t i = 0; i < later.size(); ++i) {
        CAPTURE(i);
        CHECK((later[i].type() == PacketType::stop) == (i % 2 == 0));
        if (i % 2 == 0 && i > 0) CHECK(later[i].at - later[i - 1].at >= 200ms);
        if (i % 2 == 1) CHECK(later[i].at - later[i - 1].at < 100ms);
      }
      bench.run(2s);
      REQUIRE(bench.cable->take().back().type() == PacketType::stop);
    }
    // another loss is one that the controller may start after, once something else is wanted
    bench.controller.command({Kind::run});
    bench.cable->plugged = false;
    bench.run(1s);
    bench.cable->plugged = true;
    bench.cable->take();
    bench.run(2s);
    CHECK(bench.cable->take().empty());
  }
}
