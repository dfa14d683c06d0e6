// Set-up procedure of `arkmesh fit robots`: the tracks of an arena's robots that run firmware/fit_robots.c, as a table.
// Nothing is estimated here.
#pragma once

#include <ostream>
#include <vector>

#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "testbed/set_up_arena.hpp"

namespace arkmesh::testbed {

struct WalkSettings {
  std::vector<hal::RobotId> ids;  // ascending
  double seconds = 300;           // once robots are named
};

struct WalkReport {
  std::vector<hal::RobotId> missing;  // never in the table
  std::size_t rows = 0;
  bool simulated = false;  // the arena is no real one
};

// A first line with the arena's sides and what the directions are of (LEDs, or bodies where there are no cameras), a
// header, and a row for each named robot that a picture shows. Robots are paused in the end.
WalkReport record_walks(SetUpArena& arena, const WalkSettings& settings, std::ostream& table, hal::StopRequest& stop,
                        hal::Progress& progress);

}  // namespace arkmesh::testbed
