// The smallest useful scenario: robots of every lab but the owner's light up while a robot of the owner is near in the
// shared world. Uses nothing but the scenario interface.
#pragma once

#include <map>
#include <memory>
#include <span>

#include "app/scenarios.hpp"
#include "lab/scenario.hpp"

namespace arkmesh::labs {

class LightUp final : public lab::Scenario {
 public:
  enum Kind : std::uint8_t { dark = 0, lit = 1 };  // as in light_up.c

  explicit LightUp(double reach_m) : reach_m_(reach_m) {}

  void begin(lab::Lab& lab) override {
    // How many robots were told to be lit in the newest frame.
    lab.declare({.name = "lit", .length = 1, .low = 0, .high = 1'000'000});
    lab.publish("lit", {0});
  }

  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override {
    if (lab.is_owner() || !merged_) return;
    std::int64_t n_lit = 0;
    for (const hal::Observation& seen : frame.robots) {
      const bool near = is_near(lab.projection().to_shared(seen.pose), lab.state(lab.owner()).robots);
      n_lit += near;
      // Say it when it changes, and each second until the robot's LED shows that it heard.
      Told& told = told_[seen.robot];
      const bool shows = seen.led != hal::Led::off;
      if (near == told.near && (shows == near || frame.stamp - told.when < std::chrono::seconds(1))) continue;
      told = {near, frame.stamp};
      lab.say({.robot = seen.robot, .kind = near ? lit : dark});
    }
    lab.publish("lit", {n_lit});
  }

  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}  // Kilobots say nothing

  void on_period(lab::Lab& lab) override {
    merged_ = true;
    for (const std::string& each : lab.labs())
      if (const auto& lit_there = lab.field(each, "lit"); !lit_there.empty())
        lab.counts().add("lit_periods", static_cast<std::uint64_t>(lit_there[0]));
    draw(lab);
  }

  bool finished(const lab::Lab&) const override { return false; }

 private:
  // For people: within these circles robots of this lab light up.
  void draw(lab::Lab& lab) const {
    if (lab.is_owner()) return;
    for (const lab::SharedRobot& other : lab.state(lab.owner()).robots) {
      const hal::Pose at = lab.projection().to_arena(other.in_shared);
      lab.draw(hal::Circle{.at = {at.x_m, at.y_m},
                           .radius_m = reach_m_ / lab.projection().scale,
                           .colour = hal::Colour::other,
                           .dashed = true});
    }
  }

  struct Told {
    bool near = false;
    hal::LabTime when{0};
  };

  bool is_near(const hal::Pose& p, const std::vector<lab::SharedRobot>& others) const {
    for (const lab::SharedRobot& other : others) {
      const double dx = other.in_shared.x_m - p.x_m, dy = other.in_shared.y_m - p.y_m;
      if (dx * dx + dy * dy <= reach_m_ * reach_m_) return true;
    }
    return false;
  }

  double reach_m_;
  bool merged_ = false;
  std::map<hal::RobotId, Told> told_;
};

// The catalogue's line: [scenario.light_up] reach_m = 0.10, shared frame.
inline app::CatalogueEntry light_up() {
  return {"light_up",
          [](const hal::Section& settings, const std::vector<std::string>&) -> std::unique_ptr<lab::Scenario> {
            return std::make_unique<LightUp>(settings.get("reach_m", 0.10, {.range = {0.001, 100}}));
          }};
}

}  // namespace arkmesh::labs
