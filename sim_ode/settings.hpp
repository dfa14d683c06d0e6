// The keys of [arena.ode]. README.md says where their values come from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "hal/config.hpp"
#include "hal/types.hpp"
#include "sim_ode/host/motors.hpp"

namespace arkmesh::sim_ode {

struct ViewSettings {
  bool blank_leds = false;  // arena.blank_leds: cameras see no colours

  void fields(const hal::Section& arena) {
    arena.field("blank_leds", blank_leds, {.help = "cameras see no colours (a control)"});
  }
};

struct Settings : DriveSettings {
  std::filesystem::path controller;    // a C file for kilolib
  bool leave_failed = false;           // on_fault = "end" | "leave"
  bool start_in_centre = false;        // start = "uniform" | "centre80"
  std::vector<hal::Pose> start_poses;  // of each robot in turn; wins over `start`
  bool blank_leds = false;             // arena.blank_leds: cameras see no colours
  double friction = 0.3;               // between bodies and with walls
  // sensors
  std::vector<hal::Pose> lamps;  // headings mean nothing
  double light_noise = 10;       // a reading of ambient light is off by up to this much, of 1023
  double clock_spread = 0;       // a robot's clock is off by up to this share
  // overhead controller
  hal::LabTime composite{55'000};
  double overhead_loss = 0;  // probability that a robot misses a composite
  // robot infrared
  double ir_range_m = 0.1;
  double ir_loss = 0;            // probability that a message in range is not received
  double ir_range_spread_m = 0;  // s.d. of the reach between pairs of robots
  double ir_asymmetry = 0.5;     // share of that variance that is each direction's own
  double ir_loss_per_m = 0;      // what distance adds to ir_loss
  double ir_noise_m = 0.001;     // s.d. of measured distances

  void fields(const hal::Section& ode);
  void check(const hal::Section& ode);

 private:
  double turn_deg_per_s_ = 45;
  std::vector<double> start_numbers_, lamp_numbers_;
};

// Reads arena.blank_leds and [arena.ode]; `program` stands for the controller unless it is empty. Throws ConfigError.
Settings read_settings(const hal::Section& arena, const std::filesystem::path& program = {});

}  // namespace arkmesh::sim_ode
