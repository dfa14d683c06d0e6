// Where robots stand at the beginning: at random in a region, not touching each other nor anything else, and inside the
// walls; or on places that were checked.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hal/random.hpp"
#include "hal/types.hpp"
#include "sim_ode/solid_bodies.hpp"
#include "sim_ode/start_settings.hpp"

namespace arkmesh::sim_ode {

class StartPlaces {
 public:
  // `solids` outlive it. Nobody who starts at random stands where `given` ones will.
  StartPlaces(double width_m, double height_m, const SolidBodies& solids, std::vector<hal::Pose> given = {});

  // So many more robots: on the places given by hand, unchecked, or where `start` says; headings are random then. What
  // `chance` draws decides. False: that many do not fit.
  bool add(int robots, const StartSettings& start, hal::RandomStream chance);
  const std::vector<hal::Pose>& poses() const { return poses_; }

 private:
  struct Region;
  Region region_of(const StartSettings& start) const;
  bool is_free(double x, double y) const;
  void take(const hal::Pose& pose);
  void draw(int robots, const Region& region, hal::RandomStream& chance);
  std::vector<hal::Pose> lattice(const Region& region) const;
  static std::vector<hal::Pose> grid(int robots, const std::vector<double>& at);
  bool choose(std::vector<hal::Pose> places, int robots, hal::RandomStream& chance);
  void forget_behind(std::size_t first);

  struct {
    double width_m, height_m;
  } sides_;
  double apart_m_;
  const SolidBodies& solids_;
  std::vector<hal::Pose> given_, poses_;
  // Robots by cells of one distance: whoever is too near lies in a neighbouring cell. Only cells with somebody in them.
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

// What is wrong with places given by hand, as the end of a sentence: a robot in or beyond a wall, two that overlap, one
// in an obstacle or an object.
// Empty when nothing is.
std::string error_with(const std::vector<hal::Pose>& places, double width_m, double height_m,
                       const SolidBodies& solids);

}  // namespace arkmesh::sim_ode
