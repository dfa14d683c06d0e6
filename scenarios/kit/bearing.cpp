#include "scenarios/kit/bearing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "hal/fixed_math.hpp"

namespace arkmesh::scenarios::kit {
namespace {

constexpr double circle = 2 * std::numbers::pi;

double steps(double low, double high, int bits) {
  if (bits < 1 || bits > 24 || !(low < high) || !std::isfinite(low) || !std::isfinite(high))
    throw std::invalid_argument("a number is told in 1 to 24 bits, between two bounds");
  return static_cast<double>(1U << bits);
}

}  // namespace

double bearing_rad(const hal::Pose& robot, const hal::Point& place) {
  const double x = place.x_m - robot.x_m, y = place.y_m - robot.y_m;
  if (x == 0 && y == 0) return 0;
  const double bearing = std::remainder(hal::fixed::atan2(y, x) - robot.heading_rad, circle);
  return bearing <= -std::numbers::pi ? std::numbers::pi : bearing;
}

double distance_m(const hal::Pose& robot, const hal::Point& place) {
  return hal::fixed::hypot(place.x_m - robot.x_m, place.y_m - robot.y_m);
}

int sector_of(double bearing_rad, int sectors) {
  if (sectors < 1) throw std::invalid_argument("a circle is divided into 1 sector or more");
  const double turned = bearing_rad / circle * sectors + 0.5;
  const int sector = static_cast<int>(std::floor(turned - std::floor(turned / sectors) * sectors));
  return std::clamp(sector, 0, sectors - 1);
}

std::uint32_t quantized(double value, double low, double high, int bits) {
  const double all = steps(low, high, bits), step = std::floor((value - low) / (high - low) * all);
  if (!(step > 0)) return 0;  // also not-a-number
  return static_cast<std::uint32_t>(std::min(step, all - 1));
}

double from_quantized(std::uint32_t quantized, double low, double high, int bits) {
  return low + (quantized + 0.5) * (high - low) / steps(low, high, bits);
}

}  // namespace arkmesh::scenarios::kit
