// Robots' turns with a program that is a few functions of this file.
#include "sim_ode/host/turns/turns.hpp"

#include <doctest/doctest.h>

#include <array>
#include <vector>

namespace arkmesh::sim_ode {
namespace {

// All that the library would have, as a robot's memory.
struct alignas(64) TurnVariables {
  void (*setup)(void);
  void (*loop)(void);
  void (*rx)(void*, void*);
  void* (*tx)(void);
  void (*tx_success)(void);
  std::uint32_t ticks, reads, blocks;
  std::int16_t distance[2];
  std::uint16_t uid, tx_period, irhigh[14], irlow[14];
  std::uint8_t turn_left, turn_right, straight_left, straight_right, measured;
  Message heard;
  std::uint32_t setups, loops, received, asked, sent, wait_us;
};

TurnVariables now;
arkmesh_host simulator;
Message message;

void* no_tx() {
  return nullptr;
}
void* talk() {
  ++now.asked;
  return &message;
}
int run_main() {
  now.setup = [] { ++now.setups; };
  now.loop = [] {
    ++now.loops;
    if (now.wait_us > 0) simulator.wait_us(now.wait_us, nullptr);
  };
  now.rx = [](void*, void*) { ++now.received; };
  now.tx = talk;
  now.tx_success = [] { ++now.sent; };
  now.tx_period = 3906;
  simulator.started();
  return 0;
}

struct Robots {
  explicit Robots(int robots)
      : motors(settings, robots, "shark", 1),
        leds(robots),
        bodies(robots, motors, leds, {}, "shark", 1, {}),
        memory(reinterpret_cast<char*>(&now), first, robots),
        turns(program(), memory, heaps, files, bodies, *guard,
              std::vector<RobotClock>(static_cast<std::size_t>(robots)),
              std::vector<SendTimer>(static_cast<std::size_t>(robots), SendTimer(0, {1, "send"})), false, nullptr,
              nullptr) {
    for (int i = 0; i < robots; ++i) CHECK(turns.boot(i).kind == Fault::Kind::left);
  }
  static const arkmesh_program& program() {
    static const arkmesh_program out = {
        .begin = reinterpret_cast<char*>(&now),
        .end = reinterpret_cast<char*>(&now + 1),
        .host = &simulator,
        .main = run_main,
        .setup = &now.setup,
        .loop = &now.loop,
        .rx = &now.rx,
        .tx = &now.tx,
        .no_tx = no_tx,
        .tx_success = &now.tx_success,
        .rx_message = &now.heard,
        .rx_distance = now.distance,
        .measured = &now.measured,
        .ticks = &now.ticks,
        .reads = &now.reads,
        .blocks = &now.blocks,
        .uid = &now.uid,
        .tx_period = &now.tx_period,
        .turn_left = &now.turn_left,
        .turn_right = &now.turn_right,
        .straight_left = &now.straight_left,
        .straight_right = &now.straight_right,
        .irhigh = now.irhigh,
        .irlow = now.irlow,
        .back_off = [] { return std::uint8_t{3}; },
    };
    return out;
  }
  void walk(const Inbox& inbox = {}) { CHECK(turns.walk(++tick, inbox).kind == Fault::Kind::none); }
  void command(std::uint8_t type) {
    Inbox inbox;
    inbox.overhead.emplace_back().message.type = type;
    walk(inbox);
  }
  template <class T>
  T of(int robot, const T& variable) const {
    return memory.read(robot, &variable);
  }

  std::array<std::byte, sizeof(TurnVariables)> first{};
  DriveSettings settings;
  Motors motors;
  LedLights leds;
  RobotBodies bodies;
  std::shared_ptr<FaultGuard> guard = FaultGuard::acquire();
  RobotHeaps heaps{1024, 1};
  RobotFiles files{{}, {}};
  RobotMemory memory;
  Turns turns;
  std::int64_t tick = 0;
};

}  // namespace

TEST_CASE("turns: setup, loop and messages") {
  // setup once, then loop once a tick, and once more after each message.
  Robots two(2);
  two.walk();
  CHECK(two.of(0, now.setups) == 0);
  two.command(type_run);
  for (int robot : {0, 1}) {
    CHECK(two.of(robot, now.setups) == 1);
    CHECK(two.of(robot, now.loops) == 1);
    CHECK(two.of(robot, now.uid) == robot);
    CHECK(two.of(robot, now.ticks) == 2);
  }
  Inbox inbox;
  inbox.infrared = {{.robot = 1, .at_us = 5}, {.robot = 1, .at_us = 9}};
  two.walk(inbox);
  CHECK(two.of(0, now.loops) == 2);
  CHECK(two.of(1, now.loops) == 4);
  CHECK(two.of(1, now.received) == 2);
}

TEST_CASE("turns: who waits for long in one call is told, who comes back or acts is not") {
  // Robot 0 waits for 20 s, robot 1 returns each tenth of a second.
  Robots two(2);
  two.memory.write(0, &now.wait_us, std::uint32_t{20'000'000});
  two.memory.write(1, &now.wait_us, std::uint32_t{100'000});
  two.command(type_run);
  while (two.tick * tick_us < 15'000'000) two.walk();
  const auto waits = two.turns.idle_waits(10'000'000);
  REQUIRE(waits.size() == 1);
  CHECK(waits[0].robot == 0);
  CHECK(waits[0].since_us < 1'000'000);
  CHECK(two.turns.idle_waits(16'000'000).empty());
}

TEST_CASE("turns: programs that wait") {
  // A wait past the tick keeps a stack, others' turns go on; waits take exactly their time.
  Robots two(2);
  two.memory.write(0, &now.wait_us, std::uint32_t{100'000});
  two.command(type_run);
  CHECK(two.turns.stacks_in_use() == 1);
  while (two.tick * tick_us < 10'000'000) two.walk();
  CHECK(two.of(0, now.loops) == 101);  // one each 100 ms from the first tick on
  CHECK(two.of(1, now.loops) == two.tick);
  two.command(type_reset);
  CHECK(two.turns.stacks_in_use() == 0);
  CHECK(two.turns.resets() == std::vector<int>{0, 1});
}

TEST_CASE("turns: sending") {
  // Offers come when the send timer is due and a program that runs would talk; a free channel ends the offer, a busy
  // one is asked for again after the back-off, which counts as a tick.
  Robots one(1);
  one.command(type_run);
  while (one.turns.offers().empty()) one.walk();
  CHECK(one.tick == 16);
  CHECK(one.of(0, now.asked) == 0);  // nobody is asked before its moment
  Reply reply;
  CHECK(one.turns.send({.robot = 0, .channel = Outcome::Channel::busy}, reply).kind == Fault::Kind::none);
  CHECK(reply.message);
  CHECK(reply.back_off_us == 3 * 128);
  CHECK(one.of(0, now.sent) == 0);
  one.walk();
  CHECK(one.turns.offers().size() == 1);
  reply = {};
  CHECK(one.turns.send({.robot = 0, .channel = Outcome::Channel::free}, reply).kind == Fault::Kind::none);
  CHECK(reply.message);
  CHECK(one.of(0, now.asked) == 2);
  CHECK(one.of(0, now.sent) == 1);
  one.walk();
  CHECK(one.turns.offers().empty());
  // not while it is paused
  one.command(type_wakeup);
  reply = {};
  CHECK(one.turns.send({.robot = 0, .channel = Outcome::Channel::free}, reply).kind == Fault::Kind::none);
  CHECK_FALSE(reply.message);
  CHECK(one.of(0, now.asked) == 2);
}

TEST_CASE("turns: silent since it backed off") {
  // A program may take its callback away while it waits for a free channel: it then sends nothing.
  Robots one(1);
  one.command(type_run);
  one.memory.write<void* (*)()>(0, &now.tx, nullptr);
  Reply reply;
  CHECK(one.turns.send({.robot = 0, .channel = Outcome::Channel::free}, reply).kind == Fault::Kind::none);
  CHECK_FALSE(reply.message);
}

TEST_CASE("turns: nothing is sent before setup has returned") {
  // As on a robot, which sends only once loop has its turns: also when setup waits for long.
  Robots one(1);
  one.memory.write<void (*)()>(0, &now.setup, [] {
    simulator.wait_us(5'000'000, nullptr);
    ++now.setups;
  });
  one.command(type_run);
  while (one.of(0, now.setups) == 0) {
    CHECK(one.turns.offers().empty());
    one.walk();
  }
  CHECK(one.tick > 150);
  CHECK(one.turns.offers().size() == 1);
}

TEST_CASE("turns: faults") {
  // What goes wrong in a turn is told with robot and time, wherever program code runs.
  Robots three(3);
  three.command(type_run);
  three.memory.write<void (*)(void)>(1, &now.loop, [] { simulator.ended("had enough", nullptr); });
  const Fault fault = three.turns.walk(2, {});
  CHECK(fault.kind == Fault::Kind::gave_up);
  CHECK(fault.words == "had enough");
  CHECK(three.turns.robot() == 1);
  CHECK(three.turns.now_us() == 2 * tick_us);
}

}  // namespace arkmesh::sim_ode
