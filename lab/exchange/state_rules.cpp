#include "lab/exchange/state_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/counted.hpp"
#include "lab/behaviour_hash.hpp"

namespace arkmesh::lab {
namespace {

constexpr std::string_view own_prefix = "lab.";  // of what a lab tells of itself, whatever the scenario
constexpr std::string_view arena_field = "lab.arena";
constexpr std::size_t arena_values_count = 4;
constexpr double outside_m = 0.1;  // what tracking noise and a pushed frame may add

}  // namespace

FieldRule arena_rule() {
  return {.name = std::string(arena_field),
          .length = arena_values_count,
          .low = 0,
          .high = 1'000'000'000,
          .initial_only = true};
}

FieldRule unknown_rule() {
  return {.name = "lab.unknown",
          .length = static_cast<std::size_t>(Unknown::periods) + 1,
          .low = 0,
          .high = 1,
          .initial_only = true};
}

std::vector<std::int64_t> unknown_values(std::initializer_list<Unknown> unknown) {
  std::vector<std::int64_t> values(unknown_rule().length, 0);
  for (const Unknown one : unknown) values[static_cast<std::size_t>(one)] = 1;
  return values;
}

FieldRule applied_rule(std::size_t labs) {
  return {
      .name = "lab.applied", .length = labs, .low = 0, .high = 1'000'000'000, .owner_only = true, .bookkeeping = true};
}

std::vector<std::int64_t> arena_values(const hal::ArenaInfo& arena) {
  return {to_micro(arena.width_m), to_micro(arena.height_m), static_cast<std::int64_t>(arena.robots.size()),
          std::max(arena.max_robot, arena.robots.empty() ? 0 : arena.robots.back())};
}

StateRules::StateRules(std::string owner, std::vector<FieldRule> fields,
                       std::map<std::string, hal::Projection, std::less<>> projections)
    : owner_(std::move(owner)), fields_(std::move(fields)), projections_(std::move(projections)) {}

std::optional<Refusal> StateRules::field_refusal(std::string_view lab, const LabState& state) const {
  for (const auto& [name, values] : state.fields) {
    const auto refused = [&field = name](std::string_view why, const std::string& what) {
      return Refusal{why, fmt::format("field '{}' {}", field, what)};
    };
    const auto rule = std::ranges::find(fields_, name, &FieldRule::name);
    if (rule == fields_.end()) return refused("unknown_field", "is not declared in begin()");
    if (rule->owner_only && lab != owner_)
      return refused("not_owner", fmt::format("may be published by the owner, {}, only", owner_));
    if (rule->initial_only && state.period != 0) return refused("initial_field", "belongs to state 0 only");
    if (rule->up_to ? values.size() > rule->length : values.size() != rule->length)
      return refused("field_length", fmt::format("has {} instead of {}{}", hal::counted(values.size(), "value"),
                                                 rule->up_to ? "at most " : "", rule->length));
    for (const std::int64_t value : values)
      if (value < rule->low || value > rule->high)
        return refused("field_value",
                       fmt::format("holds {}, which is not within {} to {}", value, rule->low, rule->high));
  }
  return {};
}

std::optional<Refusal> StateRules::refusal(std::string_view lab, const LabState& state, const LabState& initial) const {
  if (auto refused = field_refusal(lab, state)) return refused;
  const auto told = initial.fields.find(arena_field);
  if (told == initial.fields.end() || told->second.size() != arena_values_count)
    return Refusal{"no_arena", "its state 0 does not describe its arena"};
  const std::vector<std::int64_t>& arena = told->second;
  if (static_cast<std::int64_t>(state.robots.size()) > arena[2])
    return Refusal{"robots", fmt::format("it holds {}, but its arena has {}",
                                         hal::counted(state.robots.size(), "robot"), arena[2])};
  const auto projection = projections_.find(lab);
  if (projection == projections_.end())
    return Refusal{"no_projection", fmt::format("shared.projection.{} is missing", lab)};
  for (const SharedRobot& robot : state.robots) {
    if (robot.robot > arena[3])
      return Refusal{"robot", fmt::format("it holds robot {}, but the largest id is {}", robot.robot, arena[3])};
    const hal::Pose at = projection->second.to_arena(robot.in_shared);
    if (!(std::abs(at.x_m) <= static_cast<double>(arena[0]) * 5e-7 + outside_m) ||
        !(std::abs(at.y_m) <= static_cast<double>(arena[1]) * 5e-7 + outside_m))
      return Refusal{"position",
                     fmt::format("robot {} is at {:.3f}, {:.3f} m, outside its arena of {} x {} m", robot.robot, at.x_m,
                                 at.y_m, static_cast<double>(arena[0]) * 1e-6, static_cast<double>(arena[1]) * 1e-6)};
  }
  return {};
}

std::optional<Refusal> StateRules::world_refusal(const LabState& before, const LabState& now) const {
  for (const FieldRule& rule : fields_) {
    if (!rule.initial_only || rule.name.starts_with(own_prefix)) continue;
    const auto was = before.fields.find(rule.name), is = now.fields.find(rule.name);
    const bool had = was != before.fields.end(), has = is != now.fields.end();
    std::string change;
    if (had != has) {
      change = fmt::format("its {} is {}", rule.name, has ? "new" : "missing");
    } else if (had && was->second != is->second) {
      const auto [a, b] = std::ranges::mismatch(was->second, is->second);
      change = fmt::format("value {} of its {} was {} and is {}", a - was->second.begin(), rule.name, *a, *b);
    }
    if (!change.empty())
      return Refusal{"world", fmt::format("it was restarted with another world: {}; start all labs again", change)};
  }
  return {};
}

}  // namespace arkmesh::lab
