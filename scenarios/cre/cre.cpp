#include "scenarios/cre/cre.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "scenarios/cre/controller/cre_messages.h"
#include "scenarios/cre/fields.hpp"
#include "scenarios/wall_sensor.hpp"

namespace arkmesh::scenarios::cre {
namespace {

constexpr hal::LabTime averaged{60'000'000};  // of the means that a result states
constexpr std::size_t most_drawn = 1000;      // places; of more than that those with a resource are drawn alone

}  // namespace

Cre::Cre(Settings settings)
    : settings_(std::move(settings)), figures_(settings_.consensus, averaged), messages_(settings_.repeat) {}

void Cre::begin(lab::Lab& lab) {
  declare_fields(lab, settings_);
  lab.show({.of = "series.swarms.north", .words = "flying, committed north", .unit = "robots", .curve = true});
  lab.show({.of = "series.swarms.south", .words = "flying, committed south", .unit = "robots", .curve = true});
  lab.show({.of = "series.swarms.ground_south", .words = "ground, in the south", .unit = "robots", .curve = true});
  lab.show({.of = "colour.site_idle", .words = "place without a resource"});
  lab.show({.of = "led.0", .words = "uncommitted; ground: walking"});
  lab.show({.of = "led.1", .words = "committed north; ground: turning there"});
  lab.show({.of = "led.4", .words = "committed south; ground: turning there"});
  lab.show({.of = "led.7", .words = "ground: going to that region"});
  if (!is_ground(lab)) return;
  const double width_m = lab.arena().width_m, height_m = lab.arena().height_m;
  lab.publish("ground_um", {std::llround(width_m * 1e6), std::llround(height_m * 1e6)});
  resources_.emplace(places_on_grid(settings_.grid, width_m, height_m), settings_.resources_north,
                     settings_.resources_south, lab.random("resources"));
  lab.publish("active", resources_->active());
  lab.publish("harvested", resources_->harvested());
}

hal::Pose Cre::in_ground(const lab::Lab& lab, const hal::Pose& in_shared) const {
  return lab.projection(settings_.roles.ground).to_arena(in_shared);
}

std::uint8_t Cre::wall_near(const lab::Lab& lab, const hal::Pose& in_arena) const {
  return wall_of(blocked_sectors(in_arena, lab.arena().width_m, lab.arena().height_m, settings_.wall_zone_m));
}

void Cre::on_poses(lab::Lab& lab, const hal::PoseFrame& frame) {
  if (places_.empty()) return;
  if (lab.now() >= rules_at_) {
    lab.command(rules_of(settings_));
    rules_at_ = lab.now() + settings_.rules_repeat;
  }
  is_ground(lab) ? ground_poses(lab, frame) : flying_poses(lab, frame);
}

// Harvests, and tells robots of walls and of what they hear.
void Cre::ground_poses(lab::Lab& lab, const hal::PoseFrame& frame) {
  bool harvested = false;
  for (const hal::Observation& seen : frame.robots) {
    harvested |= resources_->harvest(seen.pose, settings_.resource_radius_m, lab.random("respawn"));
    const std::uint8_t wall = wall_near(lab, seen.pose);
    lab.tell({.robot = seen.robot, .slot = CRE_WALL_SLOT, .kind = wall}, wall == CRE_NO_WALL, settings_.repeat);
    const Speaker* speaker = nearest_speaker(speakers_, seen.pose, settings_.hear_radius_m);
    if (const auto heard = messages_.heard(lab.now(), seen.robot, seen.pose, seen.led, speaker)) lab.say(*heard);
  }
  if (!harvested) return;
  lab.publish("active", resources_->active());
  lab.publish("harvested", resources_->harvested());
}

// Readings of all robots in one frame.
void Cre::flying_poses(lab::Lab& lab, const hal::PoseFrame& frame) {
  if (lab.now() < reading_at_) return;
  reading_at_ = lab.now() + settings_.sense;
  const double radius_m =
      settings_.sense_radius_m * lab.projection().scale / lab.projection(settings_.roles.ground).scale;
  for (const hal::Observation& seen : frame.robots) {
    const hal::Pose at = in_ground(lab, lab.projection().to_shared(seen.pose));
    lab.say(reading(seen.robot, look(at, radius_m, places_, active_), wall_near(lab, seen.pose)));
  }
}

// Where the places are, once the ground lab's first state is there.
void Cre::place(lab::Lab& lab) {
  const auto& size_um = lab.initial_field(settings_.roles.ground, "ground_um");
  if (size_um.size() != 2) {
    lab.counts().add("places.missing");
    return;
  }
  width_m_ = static_cast<double>(size_um[0]) * 1e-6;
  height_m_ = static_cast<double>(size_um[1]) * 1e-6;
  places_ = places_on_grid(settings_.grid, width_m_, height_m_);
}

// Which flying robots can be heard from now on: those that are committed. A lab that is cut off is not heard.
void Cre::listen(lab::Lab& lab) {
  speakers_.clear();
  const lab::LabState& flying = lab.state(settings_.roles.flying);
  if (flying.period <= std::exchange(listened_, flying.period)) return;
  for (const lab::SharedRobot& robot : flying.robots)
    if (const auto region = opinion_of(robot.led)) speakers_.push_back({in_ground(lab, robot.in_shared), *region});
}

// What all labs have merged, as a row and as the result.
void Cre::record(lab::Lab& lab) {
  Swarms now{.time = lab.now()};
  for (const lab::SharedRobot& robot : lab.state(settings_.roles.flying).robots) {
    const auto region = opinion_of(robot.led);
    ++(region ? now.committed[index(*region)] : now.uncommitted);
  }
  for (const lab::SharedRobot& robot : lab.state(settings_.roles.ground).robots)
    now.add_ground(in_ground(lab, robot.in_shared), height_m_);
  std::vector<std::int64_t> harvested = lab.field(settings_.roles.ground, "harvested");
  harvested.resize(2);
  lab.row("swarms", swarms_header(), swarms_row(now, lab.period(), harvested));
  figures_.add(now);
  hal::Counters figures;
  figures_.tell(figures);
  for (const auto& [name, n] : figures.all()) lab.total(name, n);
  lab.total("harvested.north", static_cast<std::uint64_t>(harvested[0]));
  lab.total("harvested.south", static_cast<std::uint64_t>(harvested[1]));
}

// Both regions with their numbers of resources, the border between them, and all places: filled where a resource is.
void Cre::draw(lab::Lab& lab) const {
  const hal::Projection& ground = lab.projection(settings_.roles.ground);
  const auto here = [&](double x_m, double y_m) {
    const hal::Pose at = lab.projection().to_arena(ground.to_shared({.x_m = x_m, .y_m = y_m}));
    return hal::Point{at.x_m, at.y_m};
  };
  const double east_m = width_m_ / 2, north_m = height_m_ / 2;
  const auto draw_region = [&](double edge_m, const char* name, int resources, int others) {
    lab.draw(hal::Polygon{.corners = {here(-east_m, 0), here(east_m, 0), here(east_m, edge_m), here(-east_m, edge_m)},
                          .colour = resources < others ? hal::Colour::region_poor : hal::Colour::region_rich,
                          .filled = true,
                          .label = fmt::format("{}: {} resources", name, resources)});
  };
  draw_region(north_m, "north", settings_.resources_north, settings_.resources_south);
  draw_region(-north_m, "south", settings_.resources_south, settings_.resources_north);
  lab.draw(hal::Line{.points = {here(-east_m, 0), here(east_m, 0)}, .colour = hal::Colour::note, .dashed = true});
  const double radius_m = settings_.resource_radius_m * ground.scale / lab.projection().scale;
  const bool idle_too = places_.size() <= most_drawn;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const bool active = active_[i] == 1;
    if (!active && !idle_too) continue;
    lab.draw(hal::Circle{.at = here(places_[i].x_m, places_[i].y_m),
                         .radius_m = radius_m,
                         .colour = active ? hal::Colour::resource : hal::Colour::site_idle,
                         .filled = active,
                         .dashed = !active});
  }
}

void Cre::on_period(lab::Lab& lab) {
  if (places_.empty()) place(lab);
  if (places_.empty()) return;
  const auto& active = lab.field(settings_.roles.ground, "active");
  if (active.size() == places_.size())
    active_ = active;
  else
    active_.resize(places_.size());
  if (is_ground(lab)) listen(lab);
  record(lab);
  draw(lab);
}

bool Cre::finished(const lab::Lab&) const {
  return false;
}

}  // namespace arkmesh::scenarios::cre
