#include "lab/shared_view.hpp"

#include "lab/world_message.hpp"

namespace arkmesh::lab {

shared_view_t make_shared_view(std::uint32_t period, hal::LabTime stamp, const Projection& projection,
                               const std::vector<std::pair<std::string, const LabState*>>& merged) {
  shared_view_t view;
  view.stamp_us = stamp.count();
  view.period = static_cast<std::int32_t>(period);
  view.shift_x_m = projection.shift_x_m;
  view.shift_y_m = projection.shift_y_m;
  view.turn_rad = projection.turn_rad;
  view.scale = projection.scale;
  for (const auto& [lab, state] : merged) {
    lab_view_t& v = view.labs.emplace_back();
    v.lab = lab;
    v.period = static_cast<std::int32_t>(state->period);
    v.age_periods = view.period - v.period;
    v.robots = to_messages(state->robots);
    v.n_robots = static_cast<std::int32_t>(v.robots.size());
    v.fields = to_messages(state->fields);
    v.n_fields = static_cast<std::int32_t>(v.fields.size());
  }
  view.n_labs = static_cast<std::int32_t>(view.labs.size());
  return view;
}

}  // namespace arkmesh::lab
