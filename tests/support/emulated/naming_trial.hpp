// How long it takes on an emulated testbed until every robot has its name, and whether any name was ever
// wrong. For tests and measurements.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/counters.hpp"
#include "testbed/arena_monitor.hpp"

namespace arkmesh::tests {

struct NamingTrial {
  std::filesystem::path emulator;    // an emulator's file
  std::vector<std::string> sets;     // on top of it: "arena.robots=20"
  std::vector<std::string> lab;      // the lab's: "arena.kilobot.led_offset_deg=44"
  std::string identity = "spelled";  // or "ark"
  std::uint64_t seed = 1;
  double within_s = 30;  // max_s in all until everybody is named, the controller's start-up included
  double then_s = 0;     // how long robots run afterwards
  // For people who want to know more; the truth is that of the moment after the picture.
  std::function<void(const testbed::Look&, const std::vector<emulator::Emulator::Truth>&)> observer;
};

struct NamingResult {
  int robots = 0;
  int named = 0;                    // rightly, in the last picture
  double named_all_s = -1;          // since everything was switched on, start-up of 2 s included; below 0: never
  std::uint64_t wrong = 0;          // robot-frames in which a sure name was another robot's
  std::vector<double> named_s;      // when the n-th robot had its name for the first time
  std::vector<hal::Pose> nameless;  // where robots stand that have no name in the last picture, in truth
  hal::Counters counters;
};

// Throws what a lab would throw, except that names are missing.
NamingResult name_emulated(const NamingTrial& trial);

}  // namespace arkmesh::tests
