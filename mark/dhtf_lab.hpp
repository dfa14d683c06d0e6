// DHTF's fields of a lab that the original plays: what it said as this lab's state, and what others' states say to it.
// It tells robots nothing; the original does.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lab/scenario.hpp"
#include "mark/dhtf_conversation.hpp"
#include "scenarios/dhtf/settings.hpp"

namespace arkmesh::mark {

// The original is the client. Another lab owns the sites and judges.
class DhtfClientLab final : public lab::Scenario {
 public:
  // `talk` outlives it.
  DhtfClientLab(scenarios::dhtf::Settings settings, DhtfServerConversation& talk);
  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override;
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab&) const override { return false; }

 private:
  void meet(lab::Lab& lab);

  scenarios::dhtf::Settings settings_;
  DhtfServerConversation& talk_;
  std::vector<std::int64_t> needed_;  // per site, in this lab; empty until the labs have met
  std::vector<std::int64_t> team_;    // as published
};

// The original is the server. This lab owns the sites, which are the original's.
class DhtfServerLab final : public lab::Scenario {
 public:
  // `talk` outlives it.
  DhtfServerLab(scenarios::dhtf::Settings settings, DhtfClientConversation& talk);
  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override;
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  void on_period(lab::Lab& lab) override;
  bool finished(const lab::Lab&) const override { return false; }

 private:
  void publish_sites(lab::Lab& lab);
  void publish_levels(lab::Lab& lab);

  scenarios::dhtf::Settings settings_;
  DhtfClientConversation& talk_;
  std::vector<std::vector<std::int64_t>> needed_;  // [lab][site]; empty before Init
  std::vector<std::vector<std::int64_t>> teams_;   // [lab][site], as merged last; empty rows where nothing was heard
  std::vector<std::uint32_t> heard_;               // period of each lab's state at the last boundary
  std::vector<std::int64_t> executed_, executed_by_;
};

}  // namespace arkmesh::mark
