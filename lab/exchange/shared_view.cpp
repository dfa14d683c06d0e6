#include "lab/exchange/shared_view.hpp"

#include <chrono>

#include "arkmesh/shown_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/overlay/drawing_message.hpp"
#include "lab/exchange/world_message.hpp"

namespace arkmesh::lab {
namespace {

constexpr hal::LabTime repeat_shown = std::chrono::seconds(60);

shown_t to_message(const std::vector<Shown>& shown) {
  shown_t out;
  for (const Shown& each : shown) {
    shown_words_t& m = out.words.emplace_back();
    m.of = each.of, m.words = each.words, m.unit = each.unit, m.curve = each.curve;
  }
  out.n_words = static_cast<std::int32_t>(out.words.size());
  return out;
}

// At boundary 0, and at the first one of each further stretch of that length.
bool is_time_to_show(const LabData& lab) {
  return lab.period == 0 || lab.now / repeat_shown != (lab.now - lab.period_length) / repeat_shown;
}

}  // namespace

shared_view_t shared_view(const LabData& lab, const std::vector<MergedState>& merged) {
  const hal::Projection& projection = lab.projections.find(lab.name)->second;
  shared_view_t view;
  view.stamp_us = lab.now.count();
  view.period = static_cast<std::int32_t>(lab.period);
  view.shift_x_m = projection.shift_x_m;
  view.shift_y_m = projection.shift_y_m;
  view.turn_rad = projection.turn_rad;
  view.scale = projection.scale;
  for (const auto& [name, state, age_periods, initial, payload_age_periods] : merged) {
    lab_view_t& v = view.labs.emplace_back();
    v.lab = name;
    v.period = static_cast<std::int32_t>(state->period);
    v.age_periods = static_cast<std::int32_t>(payload_age_periods);
    v.robots = to_messages(state->robots);
    v.n_robots = static_cast<std::int32_t>(v.robots.size());
    v.fields = to_messages(state->fields);
    v.n_fields = static_cast<std::int32_t>(v.fields.size());
  }
  view.n_labs = static_cast<std::int32_t>(view.labs.size());
  return view;
}

void publish_shared(hal::Bus& bus, const LabData& lab, const shared_view_t& view) {
  bus.publish(hal::channel::shared, view);
  if (!lab.shown.empty() && is_time_to_show(lab)) bus.publish(hal::channel::shown, to_message(lab.shown));
  // An empty one takes away what was shown.
  if (!lab.drawing.empty() || lab.drawn_before)
    bus.publish(hal::channel::overlay, hal::to_message(lab.drawing, lab.now));
}

}  // namespace arkmesh::lab
