// Where robots start, as a file says it: keys of [arena.ode] and of its groups.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::sim_ode {

struct StartSettings {
  enum class Start : std::uint8_t { uniform, centre80, box, disc, ring, grid } start = Start::uniform;
  std::vector<double> start_at;        // metres: what `start` says; fields() has their meaning
  std::vector<hal::Pose> start_poses;  // of each robot in turn; wins over `start`

  void fields(const hal::Section& ode);
  void check(const hal::Section& ode);

 private:
  std::vector<double> start_numbers_;
};

}  // namespace arkmesh::sim_ode
