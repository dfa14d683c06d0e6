// What a run of CRE is judged by: who is committed, where the ground robots are, when there was a consensus. A function
// of merged states only, so it is the same in all labs.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "hal/counters.hpp"
#include "hal/types.hpp"
#include "scenarios/cre/places.hpp"

namespace arkmesh::scenarios::cre {

// Both swarms at a boundary.
struct Swarms {
  hal::LabTime time{0};
  int uncommitted = 0;
  std::array<int, 2> committed{};  // by region
  int ground = 0, ground_south = 0;
  int ground_middle = 0;        // in the middle quarter of the arena's height
  std::array<int, 10> bands{};  // ground robots in ten bands of equal height, from south to north

  void add_ground(const hal::Pose& in_ground, double height_m);
};

class SwarmFigures {
 public:
  // `consensus`: share of the flying robots; averages are over the last `window` of the run.
  SwarmFigures(double consensus, hal::LabTime window) : consensus_(consensus), window_(window) {}

  void add(const Swarms& swarms);

  // Names and values for result.json. Shares are parts per million, times milliseconds; an event that was not seen has
  // no name.
  //   consensus.ms, consensus.north or consensus.south (1)   the first one
  //   consensus.periods    boundaries since then, with it, at which it held
  //   consensus.held       of these
  //   ground.followed_ms   when 90 % of the ground robots were first in its region, since then
  //   ground.middle_peak_ppm                                  largest share in the middle quarter before it
  //   ground.south_ppm, flying.north_ppm, flying.south_ppm    means over the last minute
  void tell(hal::Counters& counts) const;

 private:
  struct Shares {
    hal::LabTime time{0};
    double ground_south = 0, flying_north = 0, flying_south = 0;
  };
  double consensus_;
  hal::LabTime window_;
  std::deque<Shares> newest_;  // of the last `window`
  std::optional<Region> region_;
  hal::LabTime consensus_at_{0};
  std::optional<hal::LabTime> followed_at_;
  double middle_peak_ = 0;
  std::uint64_t since_ = 0, held_ = 0;
};

// A row of swarms.csv.
std::string swarms_header();
std::string swarms_row(const Swarms& swarms, std::uint32_t period, const std::vector<std::int64_t>& harvested);

}  // namespace arkmesh::scenarios::cre
