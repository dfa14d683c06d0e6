#include "scenarios/cre/places.hpp"

#include <utility>

#include "scenarios/kit/bearing.hpp"

namespace arkmesh::scenarios::cre {

std::vector<hal::Pose> places_on_grid(int side, double width_m, double height_m) {
  std::vector<hal::Pose> places;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      places.push_back({.x_m = ((column + 0.5) / side - 0.5) * width_m, .y_m = (0.5 - (row + 0.5) / side) * height_m});
  return places;
}

Resources::Resources(std::vector<hal::Pose> places, int north, int south, hal::RandomStream& random)
    : places_(std::move(places)), active_(places_.size(), 0) {
  for (Region region : both_regions)
    for (int i = 0; i < (region == Region::north ? north : south); ++i) active_[draw_free(region, random)] = 1;
}

std::size_t Resources::draw_free(Region region, hal::RandomStream& random) const {
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (active_[i] == 0 && region_of(places_[i]) == region) free.push_back(i);
  return free[random.below(free.size())];
}

bool Resources::harvest(const hal::Pose& in_ground, double radius_m, hal::RandomStream& random) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (active_[i] == 0 || kit::distance2_m2(in_ground, places_[i]) >= radius_m * radius_m) continue;
    const Region region = region_of(places_[i]);
    const std::size_t next = draw_free(region, random);  // not here: this place is still taken
    active_[i] = 0;
    active_[next] = 1;
    ++harvested_[index(region)];
    return true;
  }
  return false;
}

Sight look(const hal::Pose& in_ground, double radius_m, const std::vector<hal::Pose>& places,
           const std::vector<std::int64_t>& active) {
  Sight sight;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (kit::distance2_m2(in_ground, places[i]) >= radius_m * radius_m) continue;
    const std::size_t region = index(region_of(places[i]));
    ++sight.places[region];
    sight.active[region] += active[i] == 1;
  }
  return sight;
}

}  // namespace arkmesh::scenarios::cre
