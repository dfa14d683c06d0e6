#include "scenarios/kit/light.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "scenarios/kit/bearing.hpp"

namespace arkmesh::scenarios::kit {
namespace {

double apart_m(const hal::Point& a, const hal::Point& b) {
  return std::sqrt(distance2_m2(a, b));
}

}  // namespace

Light::Light(Settings settings) : settings_(std::move(settings)) {
  for (const double level : {settings_.ambient, settings_.slope_per_m.x_m, settings_.slope_per_m.y_m})
    if (!std::isfinite(level)) throw std::invalid_argument("light's levels are numbers");
  for (const Beam& beam : settings_.beams) {
    if (beam.path.empty()) throw std::invalid_argument("a beam's path needs at least one place");
    if (!(beam.radius_m > 0) || !std::isfinite(beam.radius_m))
      throw std::invalid_argument(
          fmt::format("a beam's radius of {:g} m is not possible; give a positive one", beam.radius_m));
    if (!(beam.speed_m_s >= 0) || !std::isfinite(beam.speed_m_s) || !std::isfinite(beam.level))
      throw std::invalid_argument("a beam's speed must be 0 or more, and its level a number");
  }
}

hal::Point Light::middle(const Beam& beam, hal::LabTime now) const {
  const std::vector<hal::Point>& path = beam.path;
  double around_m = 0;
  for (std::size_t i = 0; i < path.size(); ++i) around_m += apart_m(path[i], path[(i + 1) % path.size()]);
  if (around_m == 0) return path[0];
  double left_m = std::fmod(beam.speed_m_s * std::chrono::duration<double>(now).count(), around_m);
  for (std::size_t i = 0;; i = (i + 1) % path.size()) {
    const hal::Point &from = path[i], &to = path[(i + 1) % path.size()];
    const double side_m = apart_m(from, to);
    if (left_m <= side_m && side_m > 0)
      return {from.x_m + (to.x_m - from.x_m) * left_m / side_m, from.y_m + (to.y_m - from.y_m) * left_m / side_m};
    left_m = std::max(0.0, left_m - side_m);
  }
}

double Light::at(const hal::Point& in_shared, hal::LabTime now) const {
  double level =
      settings_.ambient + settings_.slope_per_m.x_m * in_shared.x_m + settings_.slope_per_m.y_m * in_shared.y_m;
  for (const Beam& beam : settings_.beams)
    if (distance2_m2(in_shared, middle(beam, now)) <= beam.radius_m * beam.radius_m) level += beam.level;
  return std::clamp(level, 0.0, brightest);
}

void Light::draw(lab::Lab& lab, const hal::Projection& arena) const {
  for (const Beam& beam : settings_.beams) {
    const hal::Point middle_at = middle(beam, lab.now());
    const hal::Pose at = arena.to_arena({middle_at.x_m, middle_at.y_m, 0});
    lab.draw(hal::Circle{{at.x_m, at.y_m}, beam.radius_m / arena.scale, hal::Colour::note, false, true, "light"});
  }
}

}  // namespace arkmesh::scenarios::kit
