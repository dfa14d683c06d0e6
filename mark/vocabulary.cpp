#include "mark/vocabulary.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace arkmesh::mark {
namespace {

bool is_bit(char c) {
  return c == '0' || c == '1';
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

void append_bits(std::string& text, const std::vector<int>& bits) {
  for (const int bit : bits) text += bit ? '1' : '0';
}

std::vector<int> read_bits(std::string_view text) {
  std::vector<int> bits;
  for (const char c : text) bits.push_back(c == '1');
  return bits;
}

}  // namespace

std::string_view missing_text(Flavour flavour) {
  return flavour == Flavour::argos ? "Missing parameters" : "Missing initialisation";
}

std::string_view ack_text(Flavour flavour) {
  return flavour == Flavour::argos ? "Received parameters" : "Received initialisation";
}

std::string to_text(const Init& init) {
  std::string text = "I";
  for (const int cell : init.cells) text += static_cast<char>('a' + cell);
  append_bits(text, init.server_hard);
  append_bits(text, init.client_hard);
  return text;
}

std::optional<Init> read_init(std::string_view text) {
  if (text.empty() || text[0] != 'I' || text.size() % 3 != 1) return {};
  const std::size_t sites = text.size() / 3;
  if (sites == 0 || sites > most_sites) return {};
  const std::string_view letters = text.substr(1, sites), types = text.substr(1 + sites);
  Init init;
  for (const char c : letters) {
    if (c < 'a' || c > 'p' || (!init.cells.empty() && c - 'a' <= init.cells.back())) return {};
    init.cells.push_back(c - 'a');
  }
  if (!std::ranges::all_of(types, is_bit)) return {};
  init.server_hard = read_bits(types.substr(0, sites));
  init.client_hard = read_bits(types.substr(sites));
  return init;
}

std::string to_text(char first, const std::vector<int>& levels) {
  std::string text(1, first);
  append_bits(text, levels);
  return text;
}

std::optional<std::vector<int>> read_levels(std::string_view text, std::size_t count) {
  if (text.size() != count + 1 || !std::ranges::all_of(text.substr(1), is_bit)) return {};
  return read_bits(text.substr(1));
}

std::string to_text(const std::vector<FlyingRobot>& robots) {
  std::string text;
  for (const FlyingRobot& robot : robots) text += fmt::format("{:02}{:02}{}", robot.x_cm, robot.y_cm, robot.commitment);
  return text;
}

std::optional<std::vector<FlyingRobot>> read_robots(std::string_view text, int side_cm) {
  if (text.empty() || text.size() % 5 != 0 || !std::ranges::all_of(text, is_digit)) return {};
  const auto number = [](std::string_view two) { return (two[0] - '0') * 10 + (two[1] - '0'); };
  std::vector<FlyingRobot> robots;
  for (; !text.empty(); text.remove_prefix(5)) {
    const FlyingRobot robot{number(text.substr(0, 2)), number(text.substr(2, 2)), text[4] - '0'};
    if (robot.x_cm > side_cm || robot.y_cm > side_cm || robot.commitment > 2) return {};
    robots.push_back(robot);
  }
  return robots;
}

std::string resources_text(const std::vector<int>& active) {
  std::string text;
  for (const int one : active) text += one ? '0' : '1';
  return text;
}

std::optional<std::vector<int>> read_resources(std::string_view text) {
  if (text.size() != places || !std::ranges::all_of(text, is_bit)) return {};
  std::vector<int> active = read_bits(text);
  for (int& one : active) one = 1 - one;
  return active;
}

}  // namespace arkmesh::mark
