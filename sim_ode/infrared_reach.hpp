// How far one robot's infrared reaches another: differs from pair to pair and ends at shapes. Knows no messages.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim_ode/contact_world.hpp"
#include "sim_ode/settings.hpp"
#include "sim_ode/shadows.hpp"

namespace arkmesh::sim_ode {

// Nearly normal, mean 0, s.d. 1, at most 3.47: four uniform numbers from one draw.
double about_normal(std::uint64_t bits);

class InfraredReach {
 public:
  InfraredReach(const Settings& settings, const std::string& lab, std::uint64_t seed);

  // From now on these shapes block infrared. They outlive this; null: none.
  void set_blockers(const Shadows* shadows) { shadows_ = shadows; }

  // Factors on how far each robot is heard; at the beginning, or all are 1.
  void set_gains(std::vector<float> gains);

  // Of any pair.
  double longest_m() const { return longest_m_; }
  // Every pair's is the longest one, wherever robots are.
  bool same_for_all() const {
    return settings_.ir_range_spread_m == 0 && gains_.empty() && (!shadows_ || shadows_->blockers.empty());
  }
  // How far `from` is heard by `to` when nothing is in the way: always the same for the same two.
  double of_pair_m(int from, int to) const;
  // A shape is between them.
  bool is_blocked(int from, int to, const ContactWorld& world) const;
  // The distance that a robot measures where the other is as far as `distance_m`, noise apart: readings flatten, and
  // each robot sends and receives more or less strongly than the one that the tables are of.
  double measured_m(int from, int to, double distance_m) const;

 private:
  // Always the same for a robot and a kind.
  std::uint64_t own(int robot, std::uint64_t kind) const;

  Settings settings_;
  std::uint64_t pair_key_;
  double longest_m_;
  std::vector<float> gains_;  // by sender; empty: all are 1
  const Shadows* shadows_ = nullptr;
};

}  // namespace arkmesh::sim_ode
