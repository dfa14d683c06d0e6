// The keys of [arena.ode]. README.md says where their values come from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/types.hpp"
#include "sim_ode/air_settings.hpp"
#include "sim_ode/contacts.hpp"
#include "sim_ode/host/battery.hpp"
#include "sim_ode/host/motors.hpp"
#include "sim_ode/host/programs/program_sources.hpp"
#include "sim_ode/start_settings.hpp"

namespace arkmesh::sim_ode {

struct ViewSettings {
  bool blank_leds = false;  // arena.blank_leds: cameras see no colours

  void fields(const hal::Section& arena) {
    arena.field("blank_leds", blank_leds, {.help = "cameras see no colours (a control)"});
  }
};

// What keys that a file does not state are: robots as simple as can be, or as sources say of real ones.
enum class Preset : std::uint8_t { ideal, measured, measured_0 };
struct PresetKey {
  Preset preset = Preset::ideal;

  void fields(const hal::Section& ode);
};

// What robots are.
enum class Robot : std::uint8_t { kilobot, thymio };
struct RobotKey {
  Robot robot = Robot::kilobot;

  void fields(const hal::Section& ode);
};

// Whose rules robots' messages to each other obey.
enum class InfraredRules : std::uint8_t { robot, argos };

// Robots that run a program of their own, and start in a region of their own.
struct GroupSettings : StartSettings {
  int robots = 1;
  ProgramSources controller;  // no path: that of [arena.ode]; include and define go with those there
  int loops_per_tick = 1;
  std::vector<std::int64_t> ids;  // kilo_uid by robot; empty: of those of [arena.ode]
  int table = -1;                 // its place among the groups of the file; -1: the robots that are in none

  void fields(const hal::Section& group);
  void check(const hal::Section& group);
};

struct Settings : PresetKey, RobotKey, DriveSettings, BatterySettings, StartSettings {
  double turn_deg_per_s = 45;
  std::filesystem::path robots_file;  // what single robots are like; empty: as drawn
  ProgramSources controller;          // for kilolib
  int loops_per_tick = 1;             // how often a program's loop is called in a tick
  std::vector<std::int64_t> ids;      // kilo_uid by robot of groups that have none; empty: 0, 1, 2, ...
  std::vector<GroupSettings> groups;  // the rest of the robots are as [arena.ode] says
  bool leave_failed = false;          // on_fault = "end" | "leave"
  bool blank_leds = false;            // arena.blank_leds: cameras see no colours
  ContactSettings contacts;           // solver, friction
  // sensors
  std::vector<hal::Pose> lamps;  // headings mean nothing
  double light_noise = 10;       // a reading of ambient light is off by up to this much, of 1023
  // overhead controller
  hal::LabTime composite{55'000};
  double overhead_loss = 0;  // probability that a robot misses a composite
  // robot infrared
  InfraredRules infrared = InfraredRules::robot;
  hal::LabTime argos_tick{100'000};     // length of ARGoS's tick
  bool argos_ignore_conflicts = false;  // all that try in a tick succeed
  double ir_range_m = 0.1;
  double ir_loss = 0;            // probability that a message in range is not received
  double ir_range_spread_m = 0;  // s.d. of the reach between pairs of robots
  double ir_noise_m = 0.001;     // s.d. of measured distances
  AirSettings air;

  void fields(const hal::Section& ode);
  void check(const hal::Section& ode);

 private:
  std::vector<double> lamp_numbers_;
};

// presets.cpp
Settings settings_of(Preset preset, Robot robot = Robot::kilobot);

// Robots as drawn and as the file says that they are. Throws ConfigError.
std::vector<RobotProfile> profiles_of(const Settings& settings, const hal::Section& ode, int robots,
                                      const std::string& lab, std::uint64_t seed);

// Reads arena.blank_leds and [arena.ode]; `program` stands for the controller unless it is empty. Throws ConfigError.
Settings read_settings(const hal::Section& arena, const std::filesystem::path& program = {});

}  // namespace arkmesh::sim_ode
