#include "scenarios/dhtf/task_coordinator.hpp"

#include <utility>

namespace arkmesh::scenarios::dhtf {

TaskCoordinator::TaskCoordinator(std::vector<std::vector<std::int64_t>> needed, hal::LabTime respawn)
    : needed_(std::move(needed)), respawn_(respawn) {
  const std::size_t sites = needed_.empty() ? 0 : needed_.front().size();
  inactive_since_.resize(sites);
  active_.assign(sites, 1);
  executed_.assign(sites, 0);
  executed_by_.assign(sites * needed_.size(), 0);
}

bool TaskCoordinator::update(hal::LabTime now, const std::vector<std::vector<std::int64_t>>& teams,
                             const std::vector<std::int64_t>& in_force) {
  const std::size_t sites = active_.size();
  if (in_force.size() != sites) return false;
  bool decided = false;
  for (std::size_t site = 0; site < sites; ++site) {
    // Decided inactive: active again after the respawn time. Both decisions take equally long to come into force.
    if (active_[site] == 0) {
      if (now - inactive_since_[site] < respawn_) continue;
      active_[site] = 1;
      decided = true;
      continue;
    }
    // Decided active, but labs do not know yet.
    if (in_force[site] == 0) continue;
    // Every lab must have its team.
    bool complete = true;
    for (std::size_t lab = 0; lab < needed_.size(); ++lab)
      complete = complete && teams[lab].size() == sites && teams[lab][site] >= needed_[lab][site];
    if (!complete) continue;
    active_[site] = 0;
    decided = true;
    inactive_since_[site] = now;
    ++executed_[site];
    for (std::size_t lab = 0; lab < needed_.size(); ++lab) executed_by_[lab * sites + site] = teams[lab][site];
  }
  return decided;
}

}  // namespace arkmesh::scenarios::dhtf
