// How words to single robots lie in an infrared message: three groups of 24 bits, most significant first, each with the
// id of its robot, a kind and a value. Programs of different labs divide the 24 bits differently.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/message.hpp"

namespace arkmesh::hal::kilobot {

struct WordLayout {
  std::uint8_t id_bits = 10, kind_bits = 4;  // 7..10, 0..4; the rest of 24 is the value
  std::uint8_t type = 0;                     // of the message, 0..127
  constexpr int value_bits() const { return 24 - id_bits - kind_bits; }
  bool operator==(const WordLayout&) const = default;
};

// Of ARK and most of its successors.
inline constexpr WordLayout ark_layout;
inline constexpr std::size_t groups = 3;  // of a message

// The largest number that the id's bits hold: the id of a group that is for no robot.
constexpr RobotId nobody(const WordLayout& layout) {
  return (RobotId{1} << layout.id_bits) - 1;
}
constexpr RobotId largest_id(const WordLayout& layout) {
  return nobody(layout) - 1;
}

struct Word {
  RobotId robot = 0;
  std::uint8_t kind = 0;
  std::uint32_t value = 0;
  bool operator==(const Word&) const = default;
};
// The low 24 bits. Each part must fit into its bits.
constexpr std::uint32_t packed(const WordLayout& layout, const Word& word) {
  return word.robot << (24 - layout.id_bits) | static_cast<std::uint32_t>(word.kind) << layout.value_bits() |
         word.value;
}
constexpr Word unpacked(const WordLayout& layout, std::uint32_t bits) {
  return {.robot = bits >> (24 - layout.id_bits),
          .kind = static_cast<std::uint8_t>(bits >> layout.value_bits() & ((1u << layout.kind_bits) - 1)),
          .value = bits & ((1u << layout.value_bits()) - 1)};
}
// The word of a group, 0..2; the checksum is the caller's.
Word word_in(const Message& message, std::size_t group, const WordLayout& layout);
void put_word(Message& message, std::size_t group, const WordLayout& layout, const Word& word);

// Kilobots that are spoken to in this layout, and to whom their arena carries whole messages.
RobotKind kind_of(const WordLayout& layout, WholeMessages whole);
// The layout of an arena's robots; ARK's where the arena, such as one of an older recording, does not tell it.
WordLayout layout_of(const RobotKind& robot);
// As configurations and people name it: "ark", "8+16", "9+3+12 of type 5".
std::string name_of(const WordLayout& layout);

// arena.kilobot.layout: a name, or a table such as { id_bits = 8, kind_bits = 0, type = 0 }, whose absent keys are
// ARK's. Read by every arena with Kilobots in it. Throws ConfigError.
WordLayout read_layout(const Section& arena);
// The keys of read_layout, for the table of all keys.
std::vector<KeyRow> layout_keys();

}  // namespace arkmesh::hal::kilobot
