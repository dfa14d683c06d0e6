// The smallest useful scenario: robots of every lab but the owner's light up while a robot of the owner is near in the
// shared world. Uses nothing but the scenario interface, and the kit's cells to find who is near.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/config/config.hpp"
#include "lab/scenario.hpp"

namespace arkmesh::scenarios::light_up {

// [scenario.light_up]
struct Settings {
  double reach_m = 0.10;  // in the shared frame

  void fields(const hal::Section& light_up) {
    light_up.field("reach_m", reach_m,
                   {.range = {0.001, 100},
                    .unit = "m",
                    .help = "distance within which a robot of the owner's lab lights robots up"});
  }
};

class LightUp final : public lab::Scenario {
 public:
  enum Kind : std::uint8_t { dark = 0, lit = 1 };  // as in experiments/light_up/light_up.c

  explicit LightUp(const Settings& settings) : settings_(settings) {}

  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override;
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}  // Kilobots say nothing
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab&) const override { return false; }

 private:
  void draw(lab::Lab& lab) const;

  Settings settings_;
  bool merged_ = false;
};

}  // namespace arkmesh::scenarios::light_up
