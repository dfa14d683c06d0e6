#include "scenarios/light_up/light_up.hpp"

#include <chrono>

#include "scenarios/kit/neighbours.hpp"

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
  std::vector<kit::Seen> robots, others;  // in the shared frame
  const auto add = [](std::vector<kit::Seen>& to, const hal::Pose& at) { to.push_back({.place = {at.x_m, at.y_m}}); };
  for (const hal::Observation& seen : frame.robots) add(robots, lab.projection().to_shared(seen.pose));
  for (const lab::SharedRobot& other : lab.state(lab.owner()).robots) add(others, other.in_shared);
  std::vector<bool> is_near(robots.size());
  kit::each_near(robots, others, settings_.reach_m, [&](std::size_t robot, std::size_t) { is_near[robot] = true; });
  for (std::size_t i = 0; i < frame.robots.size(); ++i) {
    const hal::Observation& seen = frame.robots[i];
    const bool near = is_near[i];
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

}  // namespace arkmesh::scenarios::light_up
