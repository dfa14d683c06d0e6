#include "app/batch/batch_plan.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>

namespace arkmesh::app {
namespace {

template <class T>
std::optional<T> number(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

[[noreturn]] void refuse_range(const std::string& text) {
  throw std::invalid_argument(
      fmt::format("\"{:.60}\" must be a range FIRST..LAST, or FIRST..LAST step STEP with a STEP above 0, of 64-bit "
                  "numbers, for example \"0..1 step 0.25\"",
                  text));
}

[[noreturn]] void refuse_length(const std::string& text) {
  throw std::invalid_argument(fmt::format("\"{:.60}\" has more than {} values", text, max_batch_runs));
}

// How often `step` fits; the last value may miss it by a rounding error.
std::size_t steps_in(const std::string& text, double first, double last, double step) {
  if (!std::isfinite(first) || !std::isfinite(last) || !(step > 0) || last < first) refuse_range(text);
  const double steps = std::floor((last - first) / step + 1e-9);
  if (steps >= static_cast<double>(max_batch_runs)) refuse_length(text);
  return static_cast<std::size_t>(steps);
}

// Nothing of the rounding of FIRST + i * STEP.
std::string tidy(double value) {
  std::string text = fmt::format("{:.12g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

}  // namespace

std::vector<std::string> range_values(const std::string& text) {
  const std::size_t dots = text.find(".."), word = text.find(" step ");
  if (dots == std::string::npos) refuse_range(text);
  const std::string first = text.substr(0, dots), rest = text.substr(dots + 2);
  const std::string last = word == std::string::npos ? rest : text.substr(dots + 2, word - dots - 2);
  const std::string step = word == std::string::npos ? "1" : text.substr(word + 6);
  std::vector<std::string> out;
  if (const auto a = number<std::int64_t>(first), b = number<std::int64_t>(last), s = number<std::int64_t>(step);
      a && b && s) {
    if (*s <= 0 || *b < *a) refuse_range(text);
    // their difference may be more than a signed number holds
    const std::uint64_t steps =
        (static_cast<std::uint64_t>(*b) - static_cast<std::uint64_t>(*a)) / static_cast<std::uint64_t>(*s);
    if (steps >= max_batch_runs) refuse_length(text);
    for (std::size_t i = 0; i <= steps; ++i) out.push_back(std::to_string(*a + static_cast<std::int64_t>(i) * *s));
    return out;
  }
  const auto a = number<double>(first), b = number<double>(last), s = number<double>(step);
  if (!a || !b || !s) refuse_range(text);
  const std::size_t steps = steps_in(text, *a, *b, *s);
  for (std::size_t i = 0; i <= steps; ++i) out.push_back(tidy(*a + static_cast<double>(i) * *s));
  return out;
}

std::vector<std::int64_t> seeds_of(const std::vector<std::string>& parts) {
  std::vector<std::int64_t> seeds;
  std::set<std::int64_t> seen;
  for (const std::string& part : parts)
    for (const std::string& one : part.find("..") == std::string::npos ? std::vector{part} : range_values(part)) {
      const auto seed = number<std::int64_t>(one);
      if (!seed || *seed < 0)
        throw std::invalid_argument(fmt::format("seed {:.60} must be a whole number from 0 to 2^63-1", one));
      if (!seen.insert(*seed).second)
        throw std::invalid_argument(fmt::format("seed {} is listed twice; seed ranges must not overlap", *seed));
      seeds.push_back(*seed);
    }
  if (seeds.empty()) throw std::invalid_argument("there must be at least one seed");
  return seeds;
}

std::size_t BatchPlan::settings() const {
  std::size_t product = 1;
  for (const Factor& factor : factors) product *= factor.levels.size();
  return product;
}

std::vector<std::size_t> BatchPlan::levels_of(std::size_t setting) const {
  std::vector<std::size_t> levels(factors.size());
  for (std::size_t i = factors.size(); i-- > 0; setting /= factors[i].levels.size())
    levels[i] = setting % factors[i].levels.size();
  return levels;
}

std::vector<std::string> BatchPlan::labels_of(std::size_t setting) const {
  std::vector<std::string> labels;
  const std::vector<std::size_t> levels = levels_of(setting);
  for (std::size_t i = 0; i < factors.size(); ++i) labels.push_back(factors[i].levels[levels[i]].label);
  return labels;
}

std::string BatchPlan::name_of(std::size_t setting) const {
  const std::vector<std::string> labels = labels_of(setting);
  std::string name;
  for (std::size_t i = 0; i < factors.size(); ++i)
    name += fmt::format("{}{} = {}", i == 0 ? "" : ", ", factors[i].name, labels[i]);
  return name;
}

LabFiles BatchPlan::labs_of(std::size_t setting) const {
  LabFiles out = labs;
  const std::vector<std::size_t> levels = levels_of(setting);
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const std::vector<std::string>& sets = factors[i].levels[levels[i]].sets;
    out.sets.insert(out.sets.end(), sets.begin(), sets.end());
  }
  return out;
}

}  // namespace arkmesh::app
