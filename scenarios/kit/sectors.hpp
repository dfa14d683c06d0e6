// Virtual proximity sensors: how near walls, obstacles and other robots are in each direction, as a robot with so many
// eyes would see it. For the eight eyes of the published software, which look for walls in another way, see
// wall_sensor.hpp. Pure geometry.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::scenarios::kit {

// What eyes see, in the arena frame; metres.
class Surroundings {
 public:
  // The arena's walls, its first four sides, and its obstacles, which seem nearer than they are by the margin.
  Surroundings(double width_m, double height_m, std::span<const hal::Obstacle> obstacles = {}, double margin_m = 0);

  struct Side {
    hal::Point from, to;
    double margin_m = 0;
  };
  struct Disc {
    hal::Point centre;
    double radius_m;
    double margin_m = 0;
  };
  // Many at once cost less than one after the other.
  void add_discs(std::span<const Disc> discs);

  const std::vector<Side>& sides() const { return sides_; }
  const std::vector<Disc>& discs() const { return discs_; }
  // Those whose rim may be within `reach_m` of a place with that x, and others.
  std::span<const Disc> discs_near(double x_m, double reach_m) const;

 private:
  std::vector<Side> sides_;
  std::vector<Disc> discs_;  // ascending x
  double largest_m_ = 0;     // radius and margin
};

class Sectors {
 public:
  struct Settings {
    int count = 8;        // 1 to 16 equal sectors
    bool around = false;  // all round, sector 0 begins straight ahead; else the front half circle, sector 0 leftmost
    double reach_m = 0.1;
    // As the published software's eyes: a wall that is near, and the nearest of the rest, fill all sectors that lie
    // wholly within 90 degrees of the direction to it. In front only.
    bool half_planes = false;
    int levels = 1;  // 1: something is within reach or not; more: 0 nothing, `levels` touches the robot's centre
  };
  // Throws std::invalid_argument with one sentence for settings that make no sense.
  explicit Sectors(const Settings& settings);

  int count() const { return settings_.count; }
  // The distance to what is nearest in each sector, from the robot's centre; infinite where nothing is within reach.
  // Sectors go clockwise in the front half circle, counter-clockwise all round.
  std::vector<double> distances_m(const hal::Pose& robot, const Surroundings& what) const;
  // The same as levels.
  std::vector<int> levels(const hal::Pose& robot, const Surroundings& what) const;
  // Of levels; bit 0 is the last sector, as words for robots have the leftmost first.
  static std::uint32_t bits(std::span<const int> levels);

 private:
  std::vector<double> half_planes_m(const hal::Pose& robot, const Surroundings& what) const;

  Settings settings_;
};

}  // namespace arkmesh::scenarios::kit
