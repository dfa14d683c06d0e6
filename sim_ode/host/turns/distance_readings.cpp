#include "sim_ode/host/turns/distance_readings.hpp"

#include <algorithm>

#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::sim_ode {
namespace {

// Reading at a gap of 0 and its change per mm, for each of the tables' lines.
struct Line {
  double start, per_mm;
};
using Lines = std::array<Line, 13>;

constexpr Lines lines_of(const std::array<std::uint16_t, 14>& table) {
  Lines out{};
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k].per_mm = (table[k + 1] - table[k]) / 5.0;
    out[k].start = table[k] - out[k].per_mm * 5 * static_cast<double>(k);
  }
  return out;
}
constexpr Lines high_lines = lines_of(high_gain_table), low_lines = lines_of(low_gain_table);

}  // namespace

DistanceReadings readings_at(double distance_m) {
  // a little above, because estimates are truncated
  const double gap_mm = std::max(0.0, (distance_m - 2 * hal::kilobot::body_radius_m) * 1000 + 0.02);
  const std::size_t k = std::min<std::size_t>(static_cast<std::size_t>(gap_mm * 0.2), high_lines.size() - 1);
  const auto reading = [gap_mm](const Line& line) {
    return static_cast<std::int16_t>(std::clamp(line.start + line.per_mm * gap_mm, 0.0, 1023.0) + 0.5);
  };
  return {reading(low_lines[k]), reading(high_lines[k])};
}

}  // namespace arkmesh::sim_ode
