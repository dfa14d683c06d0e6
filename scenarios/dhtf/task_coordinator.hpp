// The owner's decisions: which tasks are executed, and when they are active again. Looks at team sizes only; what it
// decides takes effect, for the owner too, when it comes back with the owner's merged state.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenarios/dhtf/settings.hpp"

namespace arkmesh::scenarios::dhtf {

class TaskCoordinator {
 public:
  // needed[lab][site]: robots that the task of that site needs in that lab.
  TaskCoordinator(std::vector<std::vector<std::int64_t>> needed, hal::LabTime respawn);

  // At a boundary. teams[lab][site] and `in_force` (activity, 0 or 1) are what the labs merged there. A lab whose team
  // is unknown has an empty row: nothing is executed then. True when a decision was taken.
  bool update(hal::LabTime now, const std::vector<std::vector<std::int64_t>>& teams,
              const std::vector<std::int64_t>& in_force);

  // As decided so far, per site: 0 or 1; how often executed; team sizes when last executed, lab after lab.
  const std::vector<std::int64_t>& active() const { return active_; }
  const std::vector<std::int64_t>& executed() const { return executed_; }
  const std::vector<std::int64_t>& executed_by() const { return executed_by_; }

 private:
  std::vector<std::vector<std::int64_t>> needed_;
  hal::LabTime respawn_;
  std::vector<hal::LabTime> inactive_since_;
  std::vector<std::int64_t> active_, executed_, executed_by_;
};

}  // namespace arkmesh::scenarios::dhtf
