#include "scenarios/wall_sensor.hpp"

#include <cmath>
#include <numbers>

namespace arkmesh::scenarios {
namespace {

constexpr double pi = std::numbers::pi;

// Sectors both of whose edges lie within 90 degrees of `bearing` (from the robot's heading, counter-clockwise).
std::uint8_t sectors_towards(double bearing_rad) {
  constexpr double tolerance_rad = 1e-6;  // headings are known to a microradian: head-on means all eight
  std::uint8_t sectors = 0;
  bool left_edge = false;
  for (int edge = 0; edge <= 8; ++edge) {
    const double edge_rad = pi / 2 - edge * pi / 8;
    const bool towards = std::abs(std::remainder(edge_rad - bearing_rad, 2 * pi)) <= pi / 2 + tolerance_rad;
    if (edge > 0 && left_edge && towards) sectors |= static_cast<std::uint8_t>(1u << (8 - edge));
    left_edge = towards;
  }
  return sectors;
}

}  // namespace

std::uint8_t blocked_sectors(const hal::Pose& p, double width_m, double height_m, double zone_m) {
  std::uint8_t sectors = 0;
  if (width_m / 2 - p.x_m < zone_m) sectors |= sectors_towards(0 - p.heading_rad);
  if (height_m / 2 - p.y_m < zone_m) sectors |= sectors_towards(pi / 2 - p.heading_rad);
  if (width_m / 2 + p.x_m < zone_m) sectors |= sectors_towards(pi - p.heading_rad);
  if (height_m / 2 + p.y_m < zone_m) sectors |= sectors_towards(-pi / 2 - p.heading_rad);
  return sectors;
}

}  // namespace arkmesh::scenarios
