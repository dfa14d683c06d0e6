// CRE's fields of a lab that the original plays: what it said as this lab's state, and what the other lab's state says
// to it. It tells robots nothing; the original does.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lab/scenario.hpp"
#include "mark/cre_conversation.hpp"
#include "scenarios/cre/settings.hpp"

namespace arkmesh::mark {

// The original is the client, the ground swarm: its resources are this lab's.
class CreGroundLab final : public lab::Scenario {
 public:
  // `talk` outlives it; `flying_side_m`: of the arena that an original flying swarm would have.
  CreGroundLab(scenarios::cre::Settings settings, CreServerConversation& talk, double flying_side_m);
  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override;
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab&) const override { return false; }

 private:
  void check_resources() const;

  scenarios::cre::Settings settings_;
  CreServerConversation& talk_;
  double flying_side_m_;
  int begun_ = 0;            // connections of the original whose resources were checked
  std::uint32_t heard_ = 0;  // period of the flying lab's state at the last boundary
};

// The original is the server, the flying swarm: its robots are this lab's (OriginalArena).
class CreFlyingLab final : public lab::Scenario {
 public:
  // `talk` outlives it.
  CreFlyingLab(scenarios::cre::Settings settings, CreClientConversation& talk);
  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab&, const hal::PoseFrame&) override {}
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab&) const override { return false; }

 private:
  scenarios::cre::Settings settings_;
  CreClientConversation& talk_;
};

}  // namespace arkmesh::mark
