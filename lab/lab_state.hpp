// What one lab owns at the end of one period, and what others may believe of it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::lab {

struct SharedRobot {
  hal::RobotId robot = 0;
  hal::Pose in_shared;  // rounded to micrometres and microradians
  hal::Led led = hal::Led::off;
};

struct LabState {
  std::uint32_t period = 0;         // k: at lab time k*T
  std::uint64_t hash = 0;           // chained behaviour hash
  std::vector<SharedRobot> robots;  // ascending id
  std::map<std::string, std::vector<std::int64_t>, std::less<>> fields;
  std::map<std::string, std::string, std::less<>> settings;  // state 0 only
};

// A field that a scenario publishes, so that lies about it can be refused before they do harm.
struct FieldRule {
  std::string name;
  std::size_t length = 0;  // exact number of values
  std::int64_t low = 0;    // every value within low..high
  std::int64_t high = 0;
  bool owner_only = false;    // only the owner of the shared things may publish it
  bool initial_only = false;  // part of state 0 only
};

}  // namespace arkmesh::lab
