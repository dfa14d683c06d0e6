// Layouts of words: bytes by hand, the way back, the keys, and what registers promise in any layout.
#include "hal/platforms/kilobot/layout.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "hal/counters.hpp"
#include "hal/platforms/kilobot/message_registers.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"

namespace arkmesh::hal::kilobot {
namespace {

Section section(const std::string& arena) {
  return Config::from_text("[arena]\n" + arena, "lab.toml").root().section("arena");
}

WordLayout layout_in(const std::string& arena) {
  return read_layout(section(arena));
}

std::string error_in(const std::string& arena) {
  try {
    read_robot_ids(section(arena), layout_in(arena));
  } catch (const ConfigError& wrong) {
    return wrong.what();
  }
  return "none";
}

bool holds(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("three numbers of 24 bits lie most significant byte first, each in its group") {
  CHECK(hal::in_three_groups({0x123456, 0x8000, 0xFFFFFF}) ==
        std::array<std::uint8_t, 9>{0x12, 0x34, 0x56, 0, 0x80, 0, 0xFF, 0xFF, 0xFF});
}

TEST_CASE("layout: bytes of words, worked out by hand") {
  // Bits of id, kind and value from the most significant bit on; a group for nobody has all bits of the id.
  struct Row {
    const char* layout;
    Word word;
    std::array<std::uint8_t, 3> bytes, nobody;
  };
  for (const Row& row :
       {Row{"\"ark\"", {5, 1, 300}, {0x01, 0x45, 0x2C}, {0xFF, 0xC0, 0}},
        Row{"\"8+16\"", {5, 0, 0x2C01}, {0x05, 0x2C, 0x01}, {0xFF, 0, 0}},
        Row{"\"8+16\"", {254, 0, 0xFFFF}, {0xFE, 0xFF, 0xFF}, {0xFF, 0, 0}},
        Row{"\"7+17\"", {100, 0, 0x1ABCD}, {0xC9, 0xAB, 0xCD}, {0xFE, 0, 0}},
        Row{"\"7+1+16\"", {3, 1, 0xBEEF}, {0x07, 0xBE, 0xEF}, {0xFE, 0, 0}},
        Row{"{ id_bits = 9, kind_bits = 3, type = 7 }", {300, 5, 4095}, {0x96, 0x5F, 0xFF}, {0xFF, 0x80, 0}}}) {
    CAPTURE(row.layout);
    const WordLayout layout = layout_in(std::string("kilobot.layout = ") + row.layout);
    for (std::size_t group = 0; group < groups; ++group) {
      Message message;
      for (std::size_t each = 0; each < groups; ++each) put_word(message, each, layout, {.robot = nobody(layout)});
      put_word(message, group, layout, row.word);
      for (std::size_t each = 0; each < groups; ++each)
        CHECK(std::ranges::equal(std::span(message.data).subspan(3 * each, 3), each == group ? row.bytes : row.nobody));
      CHECK(word_in(message, group, layout) == row.word);
    }
  }
}

TEST_CASE("layout: keys") {
  // Names and tables; what is absent is ARK's; what no layout can be is refused where it is written.
  CHECK(layout_in("") == ark_layout);
  CHECK(layout_in("kilobot.layout = \"7+1+16\"") == WordLayout{7, 1, 0});
  CHECK(layout_in("kilobot.layout = { kind_bits = 0 }") == WordLayout{10, 0, 0});
  CHECK(layout_in("kilobot.layout = { type = 5 }") == WordLayout{10, 4, 5});
  CHECK(name_of(layout_in("kilobot.layout = { id_bits = 8, kind_bits = 0 }")) == "8+16");
  CHECK(name_of({9, 3, 5}) == "9+3+12 of type 5");
  CHECK(name_of({10, 0, 0}) == "10+14");

  CHECK(holds(error_in("kilobot.layout = \"6+18\""), "lab.toml:2: arena.kilobot.layout = \"6+18\""));
  CHECK(holds(error_in("kilobot.layout = { id_bits = 6 }"), "arena.kilobot.layout.id_bits = 6"));
  CHECK(holds(error_in("kilobot.layout = { id_bits = 11 }"), "arena.kilobot.layout.id_bits = 11"));
  CHECK(holds(error_in("kilobot.layout = { kind_bits = 5 }"), "arena.kilobot.layout.kind_bits = 5"));
  CHECK(holds(error_in("kilobot.layout = { type = 128 }"), "arena.kilobot.layout.type = 128"));
  CHECK(holds(error_in("kilobot.layout = { type = 119 }"), "118 to 120"));
  CHECK(holds(error_in("kilobot.layout = 8"), "arena.kilobot.layout = 8"));
  CHECK(holds(error_in("robots = 128\nkilobot.layout = \"7+17\""),
              "must be at most 127, the number of ids in the layout 7+17"));
  CHECK(error_in("robots = 127\nkilobot.layout = \"7+17\"") == "none");
  CHECK(layout_of(kind_of({7, 1, 9}, WholeMessages::to_nobody)) == WordLayout{7, 1, 9});
  CHECK(layout_of(RobotKind{}) == ark_layout);
}

TEST_CASE("layout: in any layout each robot's newest word goes out, in a fair round") {
  // Random layouts, robots and words: what is heard by a robot and slot is what was offered last; nobody waits longer
  // than a round; every word is accounted for; what the layout cannot carry is refused.
  std::mt19937 chance(7);
  for (int round = 0; round < 200; ++round) {
    const WordLayout layout{static_cast<std::uint8_t>(7 + chance() % 4), static_cast<std::uint8_t>(chance() % 5),
                            static_cast<std::uint8_t>(chance() % 118)};
    CAPTURE(name_of(layout));
    ArenaInfo info{kind_of(layout, WholeMessages::to_nobody)};
    for (RobotId id = 0; id <= largest_id(layout); ++id)
      if (id == largest_id(layout) || chance() % 4 == 0) info.robots.push_back(id);
    Counters counters;
    MessageRegisters registers(info, counters);
    std::map<std::pair<RobotId, int>, Word> offered;
    std::uint64_t refused = 0;
    for (int n = 0; n < 300; ++n) {
      const RobotId robot = info.robots[chance() % info.robots.size()];
      const auto slot = static_cast<std::uint8_t>(chance() % 3);
      const Word word{robot, static_cast<std::uint8_t>(chance() % info.kinds),
                      static_cast<std::uint32_t>(chance() % info.values)};
      registers.offer(std::vector<ToRobot>{{robot, slot, word.kind, word.value}});
      offered[{robot, slot}] = word;
      const bool kind_too_big = chance() % 2 == 0;
      registers.offer(std::vector<ToRobot>{
          {robot, slot, static_cast<std::uint8_t>(kind_too_big ? info.kinds : 0), kind_too_big ? 0 : info.values}});
      ++refused;
    }
    std::map<RobotId, std::size_t> left;
    for (const auto& [to, word] : offered) ++left[to.first];
    std::multimap<RobotId, Word> heard;
    while (const auto outgoing = registers.next()) {
      const Message* const message = &outgoing->message;
      CHECK(message->type == layout.type);
      CHECK(message->crc == message_crc(*message));
      for (std::size_t group = 0; group < groups; ++group)
        if (const Word word = word_in(*message, group, layout); word.robot != nobody(layout))
          heard.emplace(word.robot, word);
      // nobody has a turn more than whoever has words left
      std::size_t most = 0;
      for (const auto& [robot, words] : left) most = std::max(most, heard.count(robot));
      for (const auto& [robot, words] : left) CHECK(heard.count(robot) + 1 >= std::min(most, words));
    }
    CHECK(heard.size() == offered.size());
    for (const auto& [to, word] : offered) {
      const auto range = heard.equal_range(to.first);
      const Word& said = word;
      CHECK(std::any_of(range.first, range.second, [&](const auto& each) { return each.second == said; }));
    }
    CHECK(registers.airtime().refused == refused);
    CHECK(registers.airtime().sent == offered.size());
    CHECK(counters["to_robots.refused.kind"] + counters["to_robots.refused.value"] == refused);
  }
}

}  // namespace arkmesh::hal::kilobot
