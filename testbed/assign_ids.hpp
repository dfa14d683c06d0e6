// Set-up procedure `assign-ids`: gives each robot in an arena an id of its own. Robots run
// firmware/assign_ids.c.
#pragma once

#include <vector>

#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "testbed/set_up_arena.hpp"
#include "tracker/identity/id_assigner.hpp"

namespace arkmesh::testbed {

struct AssignIdsSettings {
  std::vector<hal::RobotId> ids;  // to give, in this order
  std::uint8_t session = 1;       // another one for each call: robots draw once per session
  double max_s = 0;               // 0: 180, and half a second for each id
};

struct AssignIdsReport {
  std::vector<tracker::IdAssigner::Robot> robots;  // by id, those without one last
  std::size_t confirmed = 0;                       // robots with an id of their own
  bool finished = false;                           // not stopped before the end
  double took_s = 0;
  bool simulated = false;  // the arena is no real one
};

AssignIdsReport assign_ids(SetUpArena& arena, const AssignIdsSettings& settings, hal::StopRequest& stop,
                           hal::Progress& progress);

}  // namespace arkmesh::testbed
