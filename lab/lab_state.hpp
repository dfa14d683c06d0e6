// What one lab owns at the end of one period.
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

}  // namespace arkmesh::lab
