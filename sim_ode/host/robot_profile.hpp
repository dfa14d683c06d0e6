// What sets one robot apart from others of its make: drawn from the spreads of [arena.ode] by seed and number, and
// replaced where a file says what a robot is truly like. How it drives: motors.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::sim_ode {

struct DriveSettings;

// Duties (0..255) at which a robot turns and goes straight at its nominal speeds; kept through a reset.
struct Calibration {
  std::uint8_t turn_left = 70, turn_right = 70, straight_left = 65, straight_right = 65;
  bool operator==(const Calibration&) const = default;
};

struct RobotProfile {
  Calibration duties;  // the calibrated ones, as its EEPROM holds them at the start
  // By how much its sides are faster than others' at the calibrated duties: both motors on, one motor on.
  double straight_left_m_s = 0, straight_right_m_s = 0, pivot_left_m_s = 0, pivot_right_m_s = 0;
  double turn_noise_rad_s = 0, turn_noise_s = 0;  // s.d. and correlation time of what wanders on top of its turn rate
  int dead_duty = 0;                              // a motor stands below it
  int start_duty = 0;                             // a motor at rest starts at it or, spun up, at dead_duty
  double charge = 1;                              // of its battery, share of a full one
  double led_bearing_rad = hal::kilobot::led_bearing_rad;
  double clock_slow = 0;     // share by which its clock is slow; negative: fast
  double send_spread = 0;    // share by which the time between two of its messages is off at most
  double infrared_gain = 1;  // of the reach of what it sends
};

// By robot number.
std::vector<RobotProfile> draw_profiles(const DriveSettings& settings, int robots, const std::string& lab,
                                        std::uint64_t seed);
// Lays what the file says of robots over `profiles`, which are those of `ids`, ascending, or count from 0 where there
// are none. Throws ConfigError.
void read_profiles(const std::filesystem::path& file, const DriveSettings& settings,
                   std::vector<RobotProfile>& profiles, std::span<const std::int64_t> ids = {});

}  // namespace arkmesh::sim_ode
