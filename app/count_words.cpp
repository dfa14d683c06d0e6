#include "app/count_words.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace arkmesh::app {
namespace {

struct Unit {
  std::string_view suffix, unit;
  double per;
};
constexpr Unit units[] = {{"ppm", "%", 1e4}, {"us", "s", 1e6}, {"ms", "s", 1e3}, {"s", "s", 1}, {"bytes", "kB", 1e3}};

}  // namespace

std::string count_words(std::string_view name, std::uint64_t n, std::string_view label) {
  const auto at = name.find_last_of("._");
  const auto* const found = std::ranges::find(
      units, at == std::string_view::npos || at == 0 ? std::string_view() : name.substr(at + 1), &Unit::suffix);
  const bool has_unit = found != std::end(units);
  std::string words(has_unit ? name.substr(0, at) : name);
  std::ranges::replace(words, '.', ' ');
  std::ranges::replace(words, '_', ' ');
  if (!label.empty()) words = label;
  if (has_unit) return fmt::format("{} {:.1f} {}", words, static_cast<double>(n) / found->per, found->unit);
  return fmt::format("{} {}", words, n);
}

}  // namespace arkmesh::app
