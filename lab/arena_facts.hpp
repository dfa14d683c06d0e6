// What a scenario may know of its lab's arena: nothing by which it could tell a simulated arena from a real one.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/arena.hpp"
#include "lab/arena_adaptation.hpp"

namespace arkmesh::lab {

struct ArenaFacts {
  double width_m = 1;                // along x
  double height_m = 1;               // along y
  std::vector<hal::RobotId> robots;  // ids that are expected, ascending
  hal::RobotId max_robot = 0;        // largest addressable id
  std::uint8_t kinds = 0;            // ToRobot::kind is below this
  std::uint16_t values = 0;          // ToRobot::value is below this
  hal::LabTime frame_period{0};      // between pose frames
  double body_radius_m = 0;          // of a robot
};

inline ArenaFacts facts_of(const hal::ArenaInfo& info) {
  return {.width_m = info.width_m,
          .height_m = info.height_m,
          .robots = info.robots,
          .max_robot = info.max_robot,
          .kinds = info.kinds,
          .values = info.values,
          .frame_period = info.frame_period,
          .body_radius_m = adapted::body_radius_m(info)};
}

}  // namespace arkmesh::lab
