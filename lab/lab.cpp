#include "lab/lab.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

namespace arkmesh::lab {
namespace {

const std::vector<std::int64_t>& field_of(const LabState& state, std::string_view field) {
  static const std::vector<std::int64_t> none;
  const auto it = state.fields.find(field);
  return it == state.fields.end() ? none : it->second;
}

}  // namespace

const hal::Projection& Lab::projection(std::string_view lab) const {
  if (const auto it = data_.projections.find(lab); it != data_.projections.end()) return it->second;
  throw std::out_of_range(fmt::format("the scenario asked for the projection of '{}', which is not one of the labs {}",
                                      lab, fmt::join(data_.labs, ", ")));
}

void Lab::drive(hal::RobotId robot, const hal::SetPoint& wheels) {
  if (!arena().can_be_driven())
    throw std::invalid_argument(fmt::format(
        "the scenario drives robot {}, but a lab cannot set the wheels of a {}; only its own program moves it", robot,
        arena().make));
  tell(hal::to_robot(robot, wheels), true);
}

void Lab::declare(FieldRule rule) {
  if (!data_.declaring)
    throw std::logic_error(
        fmt::format("the scenario declared field '{}' after begin(); declare all fields in begin()", rule.name));
  if (std::ranges::find(data_.rules, rule.name, &FieldRule::name) != data_.rules.end())
    throw std::invalid_argument(
        fmt::format("the scenario declared field '{}' twice; give each its own name", rule.name));
  data_.rules.push_back(std::move(rule));
}

void Lab::row(std::string_view table, std::string_view header, std::string_view values) {
  if (table.empty() || table.size() > 100 || table.find('/') != std::string_view::npos)
    throw std::invalid_argument(
        fmt::format("a table's name has 1 to 100 bytes and no '/', and '{:.40}' has {}", table, table.size()));
  const auto first = data_.headers.try_emplace(std::string(table), header).first;
  bool quoted = false;  // a comma between quotes parts nothing
  const auto commas = [&](std::string_view line) {
    return std::ranges::count_if(line, [&](char c) { return quoted ^= c == '"', c == ',' && !quoted; });
  };
  if (table == "hash" || table == "audit" || table == "curves" || first->second != header ||
      commas(values) != commas(header))
    throw std::invalid_argument(
        fmt::format("a row of table '{}' must have the columns of its first row, {}, with one value for each; hash, "
                    "audit and curves are the lab's own tables",
                    table, first->second));
  data_.rows.push_back({std::string(table), std::string(header), std::string(values)});
}

void Lab::show(Shown about) {
  constexpr std::size_t most = 256;
  if (!data_.declaring)
    throw std::logic_error(
        fmt::format("the scenario shows '{}' after begin(); declare in begin() what is shown", about.of));
  const std::size_t dot = std::min(about.of.find('.'), about.of.size());
  const std::string kind = about.of.substr(0, dot), name = about.of.substr(std::min(dot + 1, about.of.size()));
  const bool is_known = kind == "colour" ? hal::look_of(hal::colour_named(name)).name == name
                        : kind == "led"  ? name.size() == 1 && name >= "0" && name <= "8"
                                         : kind == "series" || kind == "setting";
  const bool is_line = hal::Drawing::is_label(about.of) && hal::Drawing::is_label(about.words) &&
                       hal::Drawing::is_label(about.unit) && about.of.find_first_of("\",") == std::string::npos;
  if (!is_known || name.empty() || !is_line || data_.shown.size() >= most)
    throw std::invalid_argument(
        fmt::format("'{:.60}' cannot be shown; up to {} of series.NAME, setting.KEY, led.0 to led.8 and colour.NAME of "
                    "view/page/colours.json can, each with words of at most {} bytes in one line",
                    about.of, most, hal::Drawing::max_label));
  const auto before = std::ranges::find(data_.shown, about.of, &Shown::of);
  if (before == data_.shown.end())
    data_.shown.push_back(std::move(about));
  else
    *before = std::move(about);
}

const LabState& Lab::merged(const States& states, std::string_view lab) const {
  if (const auto it = states.find(lab); it != states.end()) return *it->second;
  if (states.empty())
    throw std::logic_error(
        fmt::format("the scenario asked for the state of '{}' before the first merge; states are available from "
                    "on_period of period 0",
                    lab));
  throw std::out_of_range(fmt::format("the scenario asked for the state of '{}', which is not one of the labs {}", lab,
                                      fmt::join(data_.labs, ", ")));
}

const std::vector<std::int64_t>& Lab::field(std::string_view lab, std::string_view field) const {
  return field_of(state(lab), field);
}

const std::vector<std::int64_t>& Lab::initial_field(std::string_view lab, std::string_view field) const {
  return field_of(merged(data_.initial_states, lab), field);
}

hal::RandomStream& Lab::random(std::string_view purpose) {
  return stream(purpose, data_.name, purpose);
}

hal::RandomStream& Lab::common_random(std::string_view purpose) {
  return stream("/" + std::string(purpose), "", purpose);
}

hal::RandomStream& Lab::stream(std::string_view key, std::string_view lab, std::string_view purpose) {
  if (const auto it = data_.streams.find(key); it != data_.streams.end()) return it->second;
  hal::RandomStream stream(data_.seed, fmt::format("{}/{}", lab, purpose));
  return data_.streams.emplace(std::string(key), stream).first->second;
}

}  // namespace arkmesh::lab
