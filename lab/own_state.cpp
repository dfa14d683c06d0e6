#include "lab/own_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/counted.hpp"

namespace arkmesh::lab {
namespace {

std::uint64_t hash_of(const std::map<std::string, std::string, std::less<>>& settings) {
  BehaviourHash hash;
  for (const auto& [key, value] : settings)
    for (const std::string* text : {&key, &value}) {
      hash.add(text->size());
      for (const char byte : *text) hash.add(static_cast<unsigned char>(byte));
    }
  return hash.value();
}

}  // namespace

OwnState::OwnState(std::map<std::string, std::string, std::less<>> settings, const Exchange& exchange, bool is_owner)
    : settings_(std::move(settings)), settings_hash_(hash_of(settings_)), payload_(exchange, is_owner) {}

void OwnState::add(const hal::PoseFrame& frame) {
  frame_ = frame;
  hash_.add(frame_);
}

// Robots and fields as they are.
LabState OwnState::payload_now(std::uint32_t period, const LabData& lab) const {
  LabState own;
  own.period = period;
  const hal::Projection& projection = lab.projections.at(lab.name);
  own.robots.reserve(frame_.robots.size());
  for (const hal::Observation& s : frame_.robots) {
    hal::Pose shared = projection.to_shared(s.pose);
    // As others will decode it, so that all labs merge equal values.
    shared = {to_micro(shared.x_m) * 1e-6, to_micro(shared.y_m) * 1e-6, to_micro(shared.heading_rad) * 1e-6};
    own.robots.push_back({s.robot, shared, s.led});
  }
  for (const FieldRule& rule : lab.rules) {
    const auto it = lab.fields.find(rule.name);
    if (it == lab.fields.end() || (rule.initial_only && period > 0)) continue;
    own.fields.emplace(rule.name, it->second);
  }
  // What nobody declared is there to be refused.
  for (const auto& [name, values] : lab.fields)
    if (std::ranges::find(lab.rules, name, &FieldRule::name) == lab.rules.end()) own.fields.emplace(name, values);
  return own;
}

LabState OwnState::at_boundary(std::uint32_t period, const LabData& lab) {
  LabState own = payload_now(period, lab);
  // The owner's choices never enter the hash. Everything else does at every boundary, told anew or not.
  for (const FieldRule& rule : lab.rules) {
    if (rule.initial_only || rule.bookkeeping) continue;
    if (const auto it = own.fields.find(rule.name); it != own.fields.end())
      for (const std::int64_t value : it->second) hash_.add(static_cast<std::uint64_t>(value));
  }
  for (const auto& [purpose, stream] : lab.streams) hash_.add(stream.count());
  if (period == 0) {
    own.settings = settings_;
    own.settings.emplace("field.", "told");
    for (const FieldRule& rule : lab.rules)  // which all labs must declare alike
      if (!rule.name.starts_with("lab."))
        own.settings.emplace("field." + rule.name, fmt::format("{}{} within {} to {}{}{}", rule.up_to ? "at most " : "",
                                                               hal::counted(rule.length, "value"), rule.low, rule.high,
                                                               rule.owner_only ? ", of the owner only" : "",
                                                               rule.initial_only ? ", at the beginning only" : ""));
  }
  own.hash = hash_.value();
  payload_.settle(own, lab.rules);
  next_ = period + 1;
  return own;
}

std::optional<LabState> OwnState::event(const LabData& lab) {
  if (next_ == 0 || !payload_.by_events()) return {};
  LabState now = payload_now(next_, lab);
  if (!payload_.tell_early(now, lab.rules)) return {};
  return now;
}

}  // namespace arkmesh::lab
