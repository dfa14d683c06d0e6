// Dynamic heterogeneous team formation: a task is executed when every lab has its team at the task's site at the same
// time. The owner draws the sites and judges; every lab counts its own teams and tells its own robots. Knows robots by
// pose and LED only.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lab/scenario.hpp"
#include "scenarios/dhtf/robot_messages.hpp"
#include "scenarios/dhtf/settings.hpp"
#include "scenarios/dhtf/task_coordinator.hpp"

namespace arkmesh::scenarios::dhtf {

class Dhtf final : public lab::Scenario {
 public:
  explicit Dhtf(Settings settings);
  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override;
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}  // Kilobots say nothing
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab& lab) const override;

 private:
  struct Site {
    hal::Pose in_shared;
    std::int64_t cell = 0;
    std::vector<std::int64_t> hard;  // per lab, in lab order
    int timeout_s = 0;
    bool active = true;  // in force
    hal::LabTime active_since{0}, idle_since{0};
    std::int64_t executed = 0;  // in force
  };

  void decide_sites(lab::Lab& lab);
  void place_sites(lab::Lab& lab);
  void take_snapshot(lab::Lab& lab);
  void draw_sites(lab::Lab& lab) const;
  void draw_team(lab::Lab& lab, const Site& site, int ring, const std::string& of, std::int64_t team,
                 std::int64_t needed) const;
  std::int64_t needed_at(const Site& site, const lab::Lab& lab, std::size_t of) const;
  const Site* site_at(const hal::Pose& in_shared) const;

  Settings settings_;
  std::vector<Site> sites_;                     // empty until the first merge
  std::vector<std::int64_t> team_;              // own, per site, as last published
  std::optional<TaskCoordinator> coordinator_;  // the owner's
  std::vector<std::uint32_t> heard_;            // the owner's: period of each lab's state at the last boundary
};

}  // namespace arkmesh::scenarios::dhtf
