// What a scenario may know of its lab's arena: nothing by which it could tell a simulated arena from a real one.
#pragma once

#include <vector>

#include "hal/arenas/arena.hpp"

namespace arkmesh::lab {

// With what its robots are and can be told.
struct ArenaFacts : hal::RobotKind {
  double width_m = 1;                // along x
  double height_m = 1;               // along y
  std::vector<hal::RobotId> robots;  // ids that are expected, ascending
  hal::LabTime frame_period{0};      // between pose frames
  std::vector<hal::Obstacle> obstacles;
  std::vector<hal::MovableObject> objects;  // PoseFrame::objects is in this order
};

inline ArenaFacts facts_of(const hal::ArenaInfo& info) {
  return {info, info.width_m, info.height_m, info.robots, info.frame_period, info.obstacles, info.objects};
}

}  // namespace arkmesh::lab
