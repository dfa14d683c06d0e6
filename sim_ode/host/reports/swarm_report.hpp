// What a swarm did, gathered from its pose frames: colours, paths, distances between neighbours. Computes and words it;
// runs nothing.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/overlay/led_name.hpp"

namespace arkmesh::sim_ode {

// Smallest, mean and largest of some numbers; zeros when there are none.
struct Spread {
  double low = 0, mean = 0, high = 0;
};

// Distance of each robot's centre to the nearest other one, metres; empty when there is one robot only.
std::vector<double> nearest_neighbours(const hal::PoseFrame& frame);

class SwarmReport {
 public:
  // Frames in order.
  void look(const hal::PoseFrame& frame);

  // Several lines for people. Messages are read from the arena's counters.
  std::string text(const hal::Counters& counters) const;

  // Of each robot: how far it went, frame by frame, and how often its LED changed.
  const std::vector<double>& path_m() const { return path_m_; }
  const std::vector<std::uint32_t>& colour_changes() const { return changes_; }
  const hal::PoseFrame& first() const { return first_; }
  const hal::PoseFrame& last() const { return last_; }

 private:
  hal::PoseFrame first_, last_;
  std::uint64_t frames_ = 0;
  std::array<std::uint64_t, hal::led_names.size()> shown_{};  // frames x robots, by colour
  std::vector<double> path_m_;
  std::vector<std::uint32_t> changes_;
};

}  // namespace arkmesh::sim_ode
