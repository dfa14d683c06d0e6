#include "hal/platforms/kilobot/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

#include "hal/platforms/kilobot/body.hpp"
#include "hal/platforms/kilobot/packet.hpp"

namespace arkmesh::hal::kilobot {
namespace {

struct Named {
  const char* name;
  WordLayout layout;
};
// In the order of Name.
constexpr std::array named = {
    Named{"ark", ark_layout},
    Named{"8+16", {.id_bits = 8, .kind_bits = 0}},
    Named{"7+17", {.id_bits = 7, .kind_bits = 0}},
    Named{"7+1+16", {.id_bits = 7, .kind_bits = 1}},
};
enum class Name : std::uint8_t { ark, eight_16, seven_17, seven_1_16 };

struct LayoutName {
  Name name = Name::ark;
  void fields(const Section& kilobot) {
    kilobot.field("layout", name,
                  {.help = "bits of id, kind and value in a message to a robot; or a table with the keys below",
                   .one_of = {named[0].name, named[1].name, named[2].name, named[3].name}});
  }
};

struct LayoutTable {
  WordLayout layout;
  void fields(const Section& table) {
    table.field("id_bits", layout.id_bits, {{7, 10}, "bits", "bits of the robot's id, the most significant"});
    table.field("kind_bits", layout.kind_bits, {{0, 4}, "bits", "bits of the kind; the rest of 24 is the value"});
    table.field("type", layout.type, {{0, 127}, "", "type of the infrared messages"});
  }
  void check(const Section& table) const {
    // tracker/identity: robots are asked for their ids by these
    if (layout.type >= 118 && layout.type <= 120)
      table.refuse("type", "is one of 118 to 120, which identification uses; choose another");
  }
};

}  // namespace

Word word_in(const Message& message, std::size_t group, const WordLayout& layout) {
  const auto* const byte = message.data.data() + 3 * group;
  return unpacked(layout,
                  static_cast<std::uint32_t>(byte[0]) << 16 | static_cast<std::uint32_t>(byte[1]) << 8 | byte[2]);
}

void put_word(Message& message, std::size_t group, const WordLayout& layout, const Word& word) {
  const std::uint32_t bits = packed(layout, word);
  for (std::size_t k = 0; k < 3; ++k) message.data[3 * group + k] = static_cast<std::uint8_t>(bits >> (16 - 8 * k));
}

RobotKind kind_of(const WordLayout& layout, WholeMessages whole) {
  return {.make = "kilobot",
          .body_radius_m = body_radius_m,
          .height_m = board_height_m,
          .drive = {.way = RobotDrive::Way::vibration, .speed_m_s = fastest_m_s, .axle_behind_m = rear_axle_m},
          .seen_by = RobotKind::Seen::disc_and_led,
          .max_robot = largest_id(layout),
          .kinds = static_cast<std::uint8_t>(1 << layout.kind_bits),
          .values = 1u << layout.value_bits(),
          .words_per_s = groups / std::chrono::duration<double>(usual_spacing).count(),
          .id_bits = layout.id_bits,
          .kind_bits = layout.kind_bits,
          .message_type = layout.type,
          .whole = whole,
          .commands = {FleetCommand::Kind::run, FleetCommand::Kind::pause, FleetCommand::Kind::reset,
                       FleetCommand::Kind::sleep, FleetCommand::Kind::voltage, FleetCommand::Kind::charge,
                       FleetCommand::Kind::broadcast}};
}

WordLayout layout_of(const RobotKind& robot) {
  if (robot.id_bits == 0) return ark_layout;
  return {.id_bits = robot.id_bits, .kind_bits = robot.kind_bits, .type = robot.message_type};
}

std::string name_of(const WordLayout& layout) {
  const auto at = std::ranges::find(named, layout, &Named::layout);
  if (at != named.end()) return at->name;
  const std::string kind = layout.kind_bits > 0 ? fmt::format("+{}", layout.kind_bits) : "";
  const std::string type = layout.type > 0 ? fmt::format(" of type {}", layout.type) : "";
  return fmt::format("{}{}+{}{}", layout.id_bits, kind, layout.value_bits(), type);
}

WordLayout read_layout(const Section& arena) {
  const Section kilobot = arena.section("kilobot"), table = kilobot.section("layout");
  const auto is_written = [&](const char* key) { return !table.place(key).empty(); };
  if (is_written("id_bits") || is_written("kind_bits") || is_written("type")) return table.read<LayoutTable>().layout;
  return named.at(static_cast<std::size_t>(kilobot.read<LayoutName>().name)).layout;
}

std::vector<KeyRow> layout_keys() {
  std::vector<KeyRow> rows = keys_of<LayoutName>("arena.kilobot");
  std::ranges::move(keys_of<LayoutTable>("arena.kilobot.layout"), std::back_inserter(rows));
  return rows;
}

}  // namespace arkmesh::hal::kilobot
