// The overhead controller: packing, order, airtime.
#include "hal/platforms/kilobot/message_registers.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "hal/platforms/kilobot/layout.hpp"

namespace arkmesh::hal::kilobot {
namespace {

hal::ArenaInfo info_of(int robots) {
  hal::ArenaInfo info{hal::kilobot::kind_of(hal::kilobot::ark_layout, hal::WholeMessages::to_nobody)};
  for (int i = 0; i < robots; ++i) info.robots.push_back(static_cast<hal::RobotId>(i));
  return info;
}

struct Block {
  int robot, kind, value;
  bool operator==(const Block&) const = default;
};

std::vector<Block> blocks(const Message& message) {
  std::vector<Block> out;
  for (std::size_t k = 0; k < 9; k += 3) {
    const int bits = message.data[k] << 16 | message.data[k + 1] << 8 | message.data[k + 2];
    out.push_back({bits >> 14, bits >> 10 & 15, bits & 1023});
  }
  return out;
}

constexpr Block filler{1023, 0, 0};

hal::FleetCommand broadcast(std::uint8_t type, std::initializer_list<int> data) {
  hal::FleetCommand out{.kind = hal::FleetCommand::Kind::broadcast, .type = type};
  std::transform(data.begin(), data.end(), out.data.begin(), [](int byte) { return static_cast<std::uint8_t>(byte); });
  return out;
}

bool adds_up(const hal::Airtime& a) {
  return a.offered == a.sent + a.replaced + a.refused + a.not_sent + a.waiting;
}

}  // namespace

TEST_CASE("bytes of a composite") {
  // Robots (5, 1, 300) and (1000, 14, 1023) and a filler are the bytes of the published example, with its checksum.
  const hal::ArenaInfo info = info_of(1001);
  hal::Counters counters;
  MessageRegisters controller(info, counters);
  controller.offer(std::vector<hal::ToRobot>{{5, 0, 1, 300}, {1000, 0, 14, 1023}});
  const auto outgoing = controller.next();
  REQUIRE(outgoing);
  const Message* const message = &outgoing->message;
  CHECK(message->data == std::array<std::uint8_t, 9>{0x01, 0x45, 0x2C, 0xFA, 0x3B, 0xFF, 0xFF, 0xC0, 0x00});
  CHECK(message->type == 0);
  CHECK(message->crc == 0x07A8);
  CHECK_FALSE(controller.next());
}

TEST_CASE("newest wins, in a fair round") {
  // A newer value replaces an unsent one without losing its turn; every robot has its turn before any has a second one.
  const hal::ArenaInfo info = info_of(7);
  hal::Counters counters;
  MessageRegisters controller(info, counters);
  std::vector<hal::ToRobot> all;
  for (hal::RobotId id = 0; id < 7; ++id) all.push_back({id, 0, 1, 10});
  controller.offer(all);
  CHECK(controller.airtime().waiting == 7);
  CHECK(blocks(controller.next()->message) == std::vector<Block>{{0, 1, 10}, {1, 1, 10}, {2, 1, 10}});
  controller.offer(std::vector<hal::ToRobot>{{0, 0, 1, 11}, {4, 0, 1, 11}, {4, 0, 2, 12}});
  const hal::Airtime air = controller.airtime();
  CHECK(air.replaced == 2);
  CHECK(air.sent == 3);
  CHECK(adds_up(air));
  CHECK(blocks(controller.next()->message) == std::vector<Block>{{3, 1, 10}, {4, 2, 12}, {5, 1, 10}});
  CHECK(blocks(controller.next()->message) == std::vector<Block>{{6, 1, 10}, {0, 1, 11}, filler});
  CHECK_FALSE(controller.next());
  CHECK(adds_up(controller.airtime()));
}

TEST_CASE("slots") {
  // Slots of one robot are registers of their own, take turns, and never share a composite.
  const hal::ArenaInfo info = info_of(2);
  hal::Counters counters;
  MessageRegisters controller(info, counters);
  controller.offer(std::vector<hal::ToRobot>{{0, 3, 1, 30}, {0, 1, 1, 10}, {0, 200, 1, 200}});
  CHECK(blocks(controller.next()->message) == std::vector<Block>{{0, 1, 10}, filler, filler});
  controller.offer(std::vector<hal::ToRobot>{{0, 1, 1, 11}});
  CHECK(blocks(controller.next()->message)[0] == Block{0, 1, 30});
  CHECK(blocks(controller.next()->message)[0] == Block{0, 1, 200});
  CHECK(blocks(controller.next()->message)[0] == Block{0, 1, 11});
}

TEST_CASE("whole messages") {
  // One goes alone, with its own type, and takes a turn like any receiver; what is passed over is the next; each slot
  // of `everyone` is a register; only a message for one robot names its receiver.
  hal::ArenaInfo info = info_of(6);
  info.whole = hal::WholeMessages::to_each;
  hal::Counters counters;
  MessageRegisters controller(info, counters);
  const auto whole = [](hal::RobotId to, std::uint8_t slot, std::uint8_t type) {
    return hal::ToRobot{.robot = to, .slot = slot, .whole = hal::WholeMessage{type, {type, 2, 3, 4, 5, 6, 7, 8, 9}}};
  };
  controller.offer(std::vector<hal::ToRobot>{{0, 0, 1, 10},
                                             whole(1, 0, 40),
                                             {2, 0, 1, 12},
                                             whole(hal::everyone, 0, 41),
                                             {3, 0, 1, 13},
                                             whole(hal::everyone, 1, 42),
                                             whole(hal::everyone, 0, 43)});
  CHECK(controller.airtime().replaced == 1);
  CHECK(controller.airtime().waiting == 6);
  const auto words = controller.next();
  CHECK(words->has_words);
  CHECK(blocks(words->message) == std::vector<Block>{{0, 1, 10}, {2, 1, 12}, {3, 1, 13}});
  controller.offer(std::vector<hal::ToRobot>{{2, 0, 1, 22}});
  const auto to_one = controller.next();
  CHECK_FALSE(to_one->has_words);
  CHECK(to_one->only_to == hal::RobotId{1});
  CHECK(to_one->message == with_crc({.data = {40, 2, 3, 4, 5, 6, 7, 8, 9}, .type = 40}));
  CHECK(blocks(controller.next()->message) == std::vector<Block>{{2, 1, 22}, filler, filler});
  for (const std::uint8_t type : {43, 42}) {
    const auto to_all = controller.next();
    CHECK(to_all->message.type == type);
    CHECK_FALSE(to_all->only_to);
  }
  CHECK_FALSE(controller.next());
  CHECK(controller.airtime().sent == 7);
  CHECK(adds_up(controller.airtime()));
}

TEST_CASE("whole messages where an arena cannot carry them") {
  // Refused by name: to anybody, to one robot, of a type of the library's, to a robot that is not there.
  hal::ArenaInfo info = info_of(2);
  const hal::ToRobot to_one{.robot = 1, .whole = hal::WholeMessage{}},
      to_all{.robot = hal::everyone, .whole = hal::WholeMessage{}};
  hal::Counters counters;
  MessageRegisters controller(info, counters);
  controller.offer(std::vector<hal::ToRobot>{to_one, to_all});
  CHECK(counters["to_robots.refused.whole"] == 2);
  info.whole = hal::WholeMessages::to_everyone;
  controller.offer(
      std::vector<hal::ToRobot>{to_one, to_all, {.robot = hal::everyone, .whole = hal::WholeMessage{.type = 128}}});
  CHECK(counters["to_robots.refused.whole_to_one"] == 1);
  CHECK(counters["to_robots.refused.type"] == 1);
  info.whole = hal::WholeMessages::to_each;
  controller.offer(
      std::vector<hal::ToRobot>{to_one, {.robot = 2, .whole = hal::WholeMessage{}}, {.robot = hal::everyone}});
  CHECK(counters["to_robots.refused.unknown_robot"] == 2);
  CHECK(controller.airtime().waiting == 2);
  CHECK(adds_up(controller.airtime()));
}

TEST_CASE("limits") {
  // What no Kilobot could be told is refused and counted by reason; a flood of commands is refused, not stored.
  const hal::ArenaInfo info = info_of(2);
  hal::Counters counters;
  MessageRegisters controller(info, counters);
  controller.offer(std::vector<hal::ToRobot>{{2, 0, 1, 1}, {0, 0, 16, 1}, {0, 0, 1, 1024}, {1, 0, 15, 1023}});
  const hal::Airtime air = controller.airtime();
  CHECK(air.refused == 3);
  CHECK(air.waiting == 1);
  CHECK(adds_up(air));
  CHECK(counters["to_robots.refused.unknown_robot"] == 1);
  CHECK(counters["to_robots.refused.kind"] == 1);
  CHECK(counters["to_robots.refused.value"] == 1);
  controller.command(broadcast(128, {1}));
  CHECK(counters["fleet_command.refused.type"] == 1);
  for (int k = 0; k < 1000; ++k) controller.command(broadcast(9, {1}));
  CHECK(counters["fleet_command.refused.too_many"] == 936);
}

TEST_CASE("commands that a platform does not carry") {
  // Each is refused by its name and takes no airtime.
  hal::ArenaInfo info = info_of(2);
  info.commands = {hal::FleetCommand::Kind::run};
  hal::Counters counters;
  MessageRegisters controller(info, counters);
  controller.command({.kind = hal::FleetCommand::Kind::sleep});
  controller.command(broadcast(120, {1}));
  CHECK(counters["fleet_command.refused.sleep"] == 1);
  CHECK(counters["fleet_command.refused.broadcast"] == 1);
  CHECK_FALSE(controller.has_waiting());
  controller.command({.kind = hal::FleetCommand::Kind::run});
  CHECK(controller.has_waiting());
}

TEST_CASE("fleet commands go first") {
  // Commands overtake all registers, with the types of the robots' library; of words about what robots should do the
  // newest is left.
  const hal::ArenaInfo info = info_of(2);
  using Kind = hal::FleetCommand::Kind;
  constexpr std::pair<Kind, int> types[] = {{Kind::run, 0x88},   {Kind::pause, 0x85},   {Kind::reset, 0x83},
                                            {Kind::sleep, 0x84}, {Kind::voltage, 0x87}, {Kind::charge, 0x86}};
  for (const auto& [kind, type] : types) {
    hal::Counters counters;
    MessageRegisters controller(info, counters);
    controller.offer(std::vector<hal::ToRobot>{{0, 0, 1, 1}});
    for (const auto& other : types) controller.command({.kind = other.first});
    controller.command({.kind = Kind::reset});
    controller.command(broadcast(119, {1, 2, 3, 4, 5, 6, 7, 8, 9}));
    controller.command({.kind = kind});
    std::vector<int> expected{0x83, 119};
    if (kind == Kind::run)
      expected.push_back(type);
    else if (kind != Kind::reset)
      expected.insert(expected.begin(), type);
    for (int wanted : expected) {
      const auto outgoing = controller.next();
      REQUIRE(outgoing);
      const Message* const message = &outgoing->message;
      CHECK(message->type == wanted);
      CHECK(message->crc == message_crc(*message));
      if (wanted == 119) CHECK(message->data == std::array<std::uint8_t, 9>{1, 2, 3, 4, 5, 6, 7, 8, 9});
    }
    CHECK(controller.next()->message.type == 0);
  }
}

}  // namespace arkmesh::hal::kilobot
