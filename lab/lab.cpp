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
  throw std::out_of_range(fmt::format("the scenario asked for the projection of '{}', which is none of the labs {}",
                                      lab, fmt::join(data_.labs, ", ")));
}

void Lab::drive(hal::RobotId robot, const hal::SetPoint& wheels) {
  if (!arena().can_be_driven())
    throw std::invalid_argument(fmt::format(
        "the scenario drives robot {}, and a {} has no wheels that a lab can set; only its own program moves it", robot,
        arena().make));
  tell(hal::to_robot(robot, wheels), true);
}

void Lab::declare(FieldRule rule) {
  if (!data_.declaring)
    throw std::logic_error(
        fmt::format("the scenario declared field '{}' after begin(); declare all fields in begin()", rule.name));
  if (std::ranges::find(data_.rules, rule.name, &FieldRule::name) != data_.rules.end())
    throw std::invalid_argument(
        fmt::format("the scenario declared field '{}' twice; give each a name of its own", rule.name));
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
  if (table == "hash" || table == "audit" || first->second != header || commas(values) != commas(header))
    throw std::invalid_argument(
        fmt::format("a row of table '{}' must have the columns of its first row, {}, and one "
                    "value for each; hash and audit are the lab's own tables",
                    table, first->second));
  data_.rows.push_back({std::string(table), std::string(header), std::string(values)});
}

const LabState& Lab::merged(const States& states, std::string_view lab) const {
  if (const auto it = states.find(lab); it != states.end()) return *it->second;
  if (states.empty())
    throw std::logic_error(fmt::format(
        "the scenario asked for the state of '{}' before the first merge; states are there from on_period of period 0",
        lab));
  throw std::out_of_range(fmt::format("the scenario asked for the state of '{}', which is none of the labs {}", lab,
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
