#include "scenarios/light_up/light_up.hpp"

#include <algorithm>
#include <chrono>

namespace arkmesh::scenarios::light_up {

void LightUp::begin(lab::Lab& lab) {
  // How many robots were told to be lit in the newest frame.
  lab.declare({.name = "lit", .length = 1, .low = 0, .high = 1'000'000});
  lab.publish("lit", {0});
  lab.show({.of = "series.lit_periods", .words = "lit robots, summed over periods", .curve = true});
  lab.show({.of = "colour.other", .words = "robots in it light up"});
}

void LightUp::on_poses(lab::Lab& lab, const hal::PoseFrame& frame) {
  if (lab.is_owner() || !merged_) return;
  std::int64_t n_lit = 0;
  const hal::Projection& projection = lab.projection();
  const std::vector<lab::SharedRobot>& others = lab.state(lab.owner()).robots;
  for (const hal::Observation& seen : frame.robots) {
    const bool near = is_near(projection.to_shared(seen.pose), others);
    n_lit += near;
    lab.tell({.robot = seen.robot, .kind = near ? lit : dark},
             seen.led != hal::Led::unknown && (seen.led != hal::Led::off) == near);
  }
  lab.publish("lit", {n_lit});
}

void LightUp::on_period(lab::Lab& lab) {
  merged_ = true;
  std::uint64_t lit_periods = lab.counts()["lit_periods"];
  for (const std::string& each : lab.labs())
    if (const auto& lit_there = lab.field(each, "lit"); !lit_there.empty())
      lit_periods += static_cast<std::uint64_t>(lit_there[0]);
  lab.total("lit_periods", lit_periods);
  draw(lab);
}

// For people: within these circles robots of this lab light up.
void LightUp::draw(lab::Lab& lab) const {
  if (lab.is_owner()) return;
  const hal::Projection& projection = lab.projection();
  for (const lab::SharedRobot& other : lab.state(lab.owner()).robots) {
    const hal::Pose at = projection.to_arena(other.in_shared);
    lab.draw(hal::Circle{.at = {at.x_m, at.y_m},
                         .radius_m = settings_.reach_m / projection.scale,
                         .colour = hal::Colour::other,
                         .dashed = true});
  }
}

bool LightUp::is_near(const hal::Pose& p, const std::vector<lab::SharedRobot>& others) const {
  return std::ranges::any_of(others, [&](const lab::SharedRobot& other) {
    const double dx = other.in_shared.x_m - p.x_m, dy = other.in_shared.y_m - p.y_m;
    return dx * dx + dy * dy <= settings_.reach_m * settings_.reach_m;
  });
}

}  // namespace arkmesh::scenarios::light_up
