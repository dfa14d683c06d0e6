// What one lab owns at the end of one period, and its part of the shared world.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
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
  // Robots and fields are those of an earlier boundary (gate.exchange); none: of this one.
  std::optional<std::uint32_t> made_at;
  bool carried = true;  // false: in a message that leaves them out, because its receiver knows them
};

// Labs of one process hold one copy of it.
using KeptState = std::shared_ptr<const LabState>;

// As it is merged at a boundary.
struct MergedState {
  std::string lab;
  KeptState state;               // in force from now on
  std::int64_t age_periods = 0;  // how old it is at this boundary
  KeptState initial;             // its run's state 0, when this is the first of that run that is merged; else null
  std::int64_t payload_age_periods = 0;  // how old its robots and fields are, which may be older, or an early event's
};

}  // namespace arkmesh::lab
