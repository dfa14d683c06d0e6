#include "mark/cre_lab.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "scenarios/cre/fields.hpp"
#include "scenarios/cre/robot_messages.hpp"

namespace arkmesh::mark {
namespace {

namespace cre = scenarios::cre;
using lab::Unknown;

int commitment_of(hal::Led led) {
  const auto region = cre::opinion_of(led);
  return !region ? 0 : *region == cre::Region::north ? 1 : 2;
}

}  // namespace

// ---------------------------------------------------------------- the original is the ground swarm

CreGroundLab::CreGroundLab(cre::Settings settings, CreServerConversation& talk, double flying_side_m)
    : settings_(std::move(settings)), talk_(talk), flying_side_m_(flying_side_m) {}

void CreGroundLab::begin(lab::Lab& lab) {
  cre::declare_fields(lab, settings_);
  lab.publish(lab::unknown_rule().name, lab::unknown_values({Unknown::poses, Unknown::headings, Unknown::ids,
                                                             Unknown::counts, Unknown::settings, Unknown::periods}));
  lab.publish("ground_um", {std::llround(lab.arena().width_m * 1e6), std::llround(lab.arena().height_m * 1e6)});
  lab.publish("harvested", {0, 0});
}

// Each region keeps its number, so that any state shows it.
void CreGroundLab::check_resources() const {
  const std::vector<int>& active = talk_.active();
  const auto north = std::count(active.begin(), active.begin() + places / 2, 1);
  const auto south = std::count(active.begin() + places / 2, active.end(), 1);
  for (const auto& [key, ours, its] : {std::tuple{"resources_north", settings_.resources_north, north},
                                       {"resources_south", settings_.resources_south, south}})
    if (ours != its)
      throw std::runtime_error(
          fmt::format("scenario.cre.{} = {}, but the original has {}; set scenario.cre.{} = {} in all labs", key, ours,
                      its, key, its));
}

void CreGroundLab::on_poses(lab::Lab& lab, const hal::PoseFrame&) {
  if (talk_.active().empty()) return;
  if (std::exchange(begun_, talk_.begun()) != talk_.begun()) check_resources();
  lab.publish("active", {talk_.active().begin(), talk_.active().end()});
  lab.publish("harvested", {talk_.harvested()[0], talk_.harvested()[1]});
}

// The flying robots in the frame of the arena that an original flying swarm has: the ground arena, smaller.
void CreGroundLab::on_period(lab::Lab& lab) {
  const lab::LabState& flying = lab.state(settings_.roles.flying);
  // One that is cut off is not heard: its robots lead nobody.
  const bool is_heard = lab.period() == 0 || flying.period > heard_;
  heard_ = flying.period;
  const double smaller = flying_side_m_ / lab.arena().width_m;
  const int most_cm = static_cast<int>(std::lround(flying_side_m_ * 100));
  // A hundredth of a centimetre is given, so that a coordinate on a whole one is not rounded down.
  const auto centimetres = [&](double in_ground_m) {
    return std::clamp(static_cast<int>(std::floor((in_ground_m * smaller + flying_side_m_ / 2) * 100 + 1e-2)), 0,
                      most_cm);
  };
  std::vector<FlyingRobot> robots;
  for (const lab::SharedRobot& robot : flying.robots) {
    const hal::Pose at = lab.projection().to_arena(robot.in_shared);
    robots.push_back({centimetres(at.x_m), centimetres(at.y_m), is_heard ? commitment_of(robot.led) : 0});
  }
  talk_.set_robots(std::move(robots));
  lab.total("harvested.north", static_cast<std::uint64_t>(talk_.harvested()[0]));
  lab.total("harvested.south", static_cast<std::uint64_t>(talk_.harvested()[1]));
}

// ---------------------------------------------------------------- the original is the flying swarm

CreFlyingLab::CreFlyingLab(cre::Settings settings, CreClientConversation& talk)
    : settings_(std::move(settings)), talk_(talk) {}

void CreFlyingLab::begin(lab::Lab& lab) {
  cre::declare_fields(lab, settings_);
  lab.publish(lab::unknown_rule().name,
              lab::unknown_values({Unknown::headings, Unknown::ids, Unknown::settings, Unknown::periods}));
}

void CreFlyingLab::on_period(lab::Lab& lab) {
  // The original multiplies by a constant: the ground arena is that much larger.
  if (lab.period() == 0) {
    const auto& ground_um = lab.initial_field(settings_.roles.ground, "ground_um");
    const double scale = lab.projection().scale / lab.projection(settings_.roles.ground).scale;
    const double wanted_m = lab.arena().width_m * scale;
    for (const std::int64_t side_um : ground_um)
      if (std::abs(static_cast<double>(side_um) * 1e-6 - wanted_m) > 1e-3)
        throw std::runtime_error(
            fmt::format("the arena of {} is {} m wide, but the original's, {} m wide (mark.side_m), covers {} m of it "
                        "by shared.projection; correct shared.projection, or arena.width_m of {}",
                        settings_.roles.ground, static_cast<double>(side_um) * 1e-6, lab.arena().width_m, wanted_m,
                        settings_.roles.ground));
  }
  const auto& active = lab.field(settings_.roles.ground, "active");
  if (active.size() == places) talk_.set_active({active.begin(), active.end()});
}

}  // namespace arkmesh::mark
