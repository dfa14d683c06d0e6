// The words of the original: its messages without delimiters, written and read. Pure; whatever comes from outside is
// read here, and nothing that does not fit becomes a value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mark/settings.hpp"

namespace arkmesh::mark {

enum class Word : std::uint8_t {
  missing,       // DHTF, client: it has no Init yet
  init,          // DHTF, server: sites and types
  ack,           // DHTF, client: it has read Init
  empty,         // DHTF, ARGoS server: once, when it has seen the ack
  ready,         // DHTF, client: T and a digit per site, 1 where its team is complete
  accomplished,  // DHTF, server: A and a digit per site, 1 where the site is inactive
  banner,        // ARK-Qt server, when somebody connects
  stopped,       // ARK-Qt server: its operator stopped the experiment
  robots,        // CRE, flying server: five digits per robot
  resources      // CRE, ground client: a digit per place, 0 where a resource is
};

// One message.
struct Message {
  Word word = Word::empty;
  std::string text;  // without delimiter
  bool operator==(const Message&) const = default;
};

inline constexpr std::string_view banner_text = "Reply: connection established";
inline constexpr std::string_view stop_text = "0";
// "Missing parameters" and "Received parameters" of ARGoS; ARK-Qt has "initialisation" instead.
std::string_view missing_text(Flavour flavour);
std::string_view ack_text(Flavour flavour);

// --- DHTF ---
inline constexpr std::size_t most_sites = 16;  // letters a to p
struct Init {
  std::vector<int> cells;                     // 0..15, ascending
  std::vector<int> server_hard, client_hard;  // 1 hard, 0 easy; in the order of cells
  bool operator==(const Init&) const = default;
};
std::string to_text(const Init& init);
// None unless it is I, letters that ascend, and two digits 0 or 1 for each.
std::optional<Init> read_init(std::string_view text);

// T or A and digits; `levels` of 0 or 1.
std::string to_text(char first, const std::vector<int>& levels);
// The digits 0 or 1 behind the first character; none when there are others or not `count` of them.
std::optional<std::vector<int>> read_levels(std::string_view text, std::size_t count);

// --- CRE ---
inline constexpr std::size_t places = 100;
// A flying robot: centimetres from the south-west corner of the flying arena, rounded down; commitment 0 none, 1 north,
// 2 south.
struct FlyingRobot {
  int x_cm = 0, y_cm = 0, commitment = 0;
  bool operator==(const FlyingRobot&) const = default;
};
std::string to_text(const std::vector<FlyingRobot>& robots);
// None when it is no whole number of robots, or one is beyond `side_cm` or has another commitment.
std::optional<std::vector<FlyingRobot>> read_robots(std::string_view text, int side_cm);
// `active`: 1 where a resource is; the text has 0 there.
std::string resources_text(const std::vector<int>& active);
std::optional<std::vector<int>> read_resources(std::string_view text);

}  // namespace arkmesh::mark
