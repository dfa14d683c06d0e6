#include "lab/exchange/payload.hpp"

#include <algorithm>

namespace arkmesh::lab {
namespace {

// Of what robots and sites do: neither bookkeeping nor decided once.
bool is_relevant(const std::string& field, const std::vector<FieldRule>& rules) {
  const auto rule = std::ranges::find(rules, field, &FieldRule::name);
  return rule == rules.end() || !(rule->initial_only || rule->bookkeeping);
}

bool same_robots_and_leds(const LabState& now, const LabState& before) {
  return std::ranges::equal(now.robots, before.robots, [](const SharedRobot& a, const SharedRobot& b) {
    return a.robot == b.robot && a.led == b.led;
  });
}

// A field that was published once stays, so those of `now` are all.
bool is_event_after(const LabState& now, const LabState& before, const std::vector<FieldRule>& rules) {
  bool any = false;
  for (const auto& [name, values] : now.fields) {
    if (!is_relevant(name, rules)) continue;
    any = true;
    const auto was = before.fields.find(name);
    if (was == before.fields.end() || was->second != values) return true;
  }
  return !any && !same_robots_and_leds(now, before);
}

}  // namespace

std::vector<std::int64_t> payload_periods(const std::vector<MergedState>& merged) {
  std::vector<std::int64_t> periods;
  for (const MergedState& one : merged) periods.push_back(payload_period(*one.state));
  return periods;
}

void leave_out_payload(LabState& state) {
  state.made_at = payload_period(state);
  state.carried = false;
  state.robots.clear();
  state.fields.clear();
}

void repeat_payload(LabState& state, const LabState& known, const std::vector<FieldRule>& rules) {
  state.made_at = payload_period(known);
  state.carried = true;
  state.robots = known.robots;
  state.fields = known.fields;
  if (state.period == 0) return;
  for (const FieldRule& rule : rules)
    if (rule.initial_only) state.fields.erase(rule.name);
}

OwnPayload::OwnPayload(const Exchange& exchange, bool is_owner)
    : by_events_(exchange.by_events(is_owner)), every_(exchange.every(is_owner)) {}

bool OwnPayload::is_due(const LabState& own, const std::vector<FieldRule>& rules) const {
  if (own.period == 0) return true;
  return by_events_ ? is_event_after(own, newest_, rules) : own.period % every_ == 0;
}

void OwnPayload::settle(LabState& own, const std::vector<FieldRule>& rules) {
  if (!by_events_ && every_ == 1) return;
  if (is_due(own, rules))
    newest_ = own;
  else
    repeat_payload(own, newest_, rules);
  if (by_events_) told_ = own;
}

bool OwnPayload::tell_early(const LabState& now, const std::vector<FieldRule>& rules) {
  if (!by_events_ || !is_event_after(now, told_, rules)) return false;
  told_ = now;
  return true;
}

}  // namespace arkmesh::lab
