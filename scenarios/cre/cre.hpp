// Collective resource exploitation: a flying swarm senses both regions of the world and agrees on the better one; a
// ground swarm, which harvests, hears flying robots near it and follows them. The ground swarm's lab owns the
// resources. Which lab plays which part is a setting. Knows robots by pose and LED only.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "lab/scenario.hpp"
#include "scenarios/cre/places.hpp"
#include "scenarios/cre/robot_messages.hpp"
#include "scenarios/cre/settings.hpp"
#include "scenarios/cre/swarm_figures.hpp"

namespace arkmesh::scenarios::cre {

class Cre final : public lab::Scenario {
 public:
  explicit Cre(Settings settings);
  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override;
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}  // Kilobots say nothing
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab& lab) const override;

 private:
  bool is_ground(const lab::Lab& lab) const { return lab.name() == settings_.roles.ground; }
  // To the ground arena's frame.
  hal::Pose in_ground(const lab::Lab& lab, const hal::Pose& in_shared) const;
  std::uint8_t wall_near(const lab::Lab& lab, const hal::Pose& in_arena) const;
  void ground_poses(lab::Lab& lab, const hal::PoseFrame& frame);
  void flying_poses(lab::Lab& lab, const hal::PoseFrame& frame);
  void place(lab::Lab& lab);
  void listen(lab::Lab& lab);
  void record(lab::Lab& lab);
  void draw(lab::Lab& lab) const;

  Settings settings_;
  double width_m_ = 0, height_m_ = 0;  // of the ground arena
  std::vector<hal::Pose> places_;      // empty until the first merge
  std::vector<std::int64_t> active_;   // per place, as merged
  SwarmFigures figures_;
  hal::LabTime rules_at_{0}, reading_at_{0};
  // The ground lab's.
  std::optional<Resources> resources_;
  std::vector<Speaker> speakers_;
  std::uint32_t listened_ = 0;  // period of the flying lab's state at the last boundary
  GroundMessages messages_;
};

}  // namespace arkmesh::scenarios::cre
