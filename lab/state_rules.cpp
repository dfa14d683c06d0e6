#include "lab/state_rules.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/behaviour_hash.hpp"

namespace arkmesh::lab {
namespace {

const std::string arena_field = "lab.arena";
constexpr double outside_m = 0.1;  // what tracking noise and a pushed frame may add

}  // namespace

FieldRule arena_rule() {
  return {.name = arena_field, .length = 4, .low = 0, .high = 1'000'000'000, .initial_only = true};
}

std::vector<std::int64_t> arena_values(const hal::ArenaInfo& arena) {
  return {to_micro(arena.width_m), to_micro(arena.height_m), static_cast<std::int64_t>(arena.robots.size()),
          arena.max_robot};
}

StateRules::StateRules(std::string owner, std::vector<FieldRule> fields,
                       std::map<std::string, Projection, std::less<>> projections)
    : owner_(std::move(owner)), fields_(std::move(fields)), projections_(std::move(projections)) {}

std::string_view StateRules::refused_field(std::string_view lab, const LabState& state) const {
  for (const auto& [name, values] : state.fields) {
    const auto rule =
        std::find_if(fields_.begin(), fields_.end(), [&field = name](const FieldRule& r) { return r.name == field; });
    if (rule == fields_.end()) return "unknown_field";
    if (rule->owner_only && lab != owner_) return "not_owner";
    if (rule->initial_only && state.period != 0) return "initial_field";
    if (values.size() != rule->length) return "field_length";
    for (const std::int64_t value : values)
      if (value < rule->low || value > rule->high) return "field_value";
  }
  return {};
}

std::string_view StateRules::why_refused(std::string_view lab, const LabState& state, const LabState& initial) const {
  if (const std::string_view why = refused_field(lab, state); !why.empty()) return why;
  const auto told = initial.fields.find(arena_field);
  if (told == initial.fields.end() || told->second.size() != arena_rule().length) return "no_arena";
  const std::vector<std::int64_t>& arena = told->second;
  if (static_cast<std::int64_t>(state.robots.size()) > arena[2]) return "robots";
  const auto projection = projections_.find(lab);
  if (projection == projections_.end()) return "no_projection";
  for (const SharedRobot& robot : state.robots) {
    if (robot.robot > arena[3]) return "robot";
    const hal::Pose at = projection->second.to_arena(robot.in_shared);
    if (!(std::abs(at.x_m) <= static_cast<double>(arena[0]) * 5e-7 + outside_m) ||
        !(std::abs(at.y_m) <= static_cast<double>(arena[1]) * 5e-7 + outside_m))
      return "position";
  }
  return {};
}

}  // namespace arkmesh::lab
