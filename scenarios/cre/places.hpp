// The world of CRE: two regions of the ground arena, north and south, and places in which resources can be. All
// positions are in the ground arena's frame, to which labs project their robots. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/random.hpp"
#include "hal/types.hpp"

namespace arkmesh::scenarios::cre {

enum class Region : std::uint8_t { north = 0, south = 1 };
inline constexpr std::array both_regions{Region::north, Region::south};
constexpr std::size_t index(Region region) {
  return static_cast<std::size_t>(region);
}
constexpr Region region_of(const hal::Pose& in_ground) {
  return in_ground.y_m > 0 ? Region::north : Region::south;
}

// Centres of a grid of `side` x `side` cells of the ground arena, row by row from the north-west: the first half of
// them is the north's.
std::vector<hal::Pose> places_on_grid(int side, double width_m, double height_m);

// Which places hold a resource. Each region keeps its number: what is harvested appears elsewhere in the same region.
class Resources {
 public:
  // `places` as of places_on_grid; a region has more places than resources.
  Resources(std::vector<hal::Pose> places, int north, int south, hal::RandomStream& random);

  // A robot is at `in_ground`. True when it harvests: then the resource has moved to a place that was free, drawn
  // evenly.
  bool harvest(const hal::Pose& in_ground, double radius_m, hal::RandomStream& random);

  // Per place: 0 or 1.
  const std::vector<std::int64_t>& active() const { return active_; }
  // Per region.
  const std::vector<std::int64_t>& harvested() const { return harvested_; }

 private:
  // A free place of the region, drawn evenly.
  std::size_t draw_free(Region region, hal::RandomStream& random) const;

  std::vector<hal::Pose> places_;
  std::vector<std::int64_t> active_, harvested_{0, 0};
};

// What a flying robot senses of each region: active places and all places nearer than `radius_m`.
struct Sight {
  std::array<int, 2> active{}, places{};
};
Sight look(const hal::Pose& in_ground, double radius_m, const std::vector<hal::Pose>& places,
           const std::vector<std::int64_t>& active);

}  // namespace arkmesh::scenarios::cre
