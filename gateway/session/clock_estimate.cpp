#include "gateway/session/clock_estimate.hpp"

#include <algorithm>

namespace arkmesh::gateway {
namespace {

// What clocks of computers drift apart at most: their crystals are specified to 20 to 100 ppm.
constexpr double most_drift_ppm = 100;
constexpr std::int64_t row_us = 10'000'000;
// Longer away than this, or further in either clock, is no heartbeat of ours.
constexpr std::int64_t longest_us = std::int64_t{1} << 60, longest_trip_us = 3'600'000'000;

bool sane(std::int64_t us) {
  return us > -longest_us && us < longest_us;
}

}  // namespace

std::int64_t monotonic_us(std::chrono::steady_clock::time_point at) {
  return std::chrono::duration_cast<std::chrono::microseconds>(at.time_since_epoch()).count();
}

std::int64_t wall_ahead_us(std::chrono::steady_clock::time_point at) {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(wall).count() - monotonic_us(at);
}

bool ClockEstimate::add(const RoundTrip& trip) {
  for (const std::int64_t us : {trip.sent_us, trip.peer_heard_us, trip.peer_sent_us, trip.heard_us})
    if (!sane(us)) return false;
  const std::int64_t away = trip.heard_us - trip.sent_us, held = trip.peer_sent_us - trip.peer_heard_us;
  if (away < 0 || held < 0 || held > away || away > longest_trip_us || trip.heard_us < newest_us_) return false;
  const Trip newest{trip.heard_us, ((trip.peer_heard_us - trip.sent_us) + (trip.peer_sent_us - trip.heard_us)) / 2,
                    away - held};
  if (!best_ || newest.at_us - row_began_us_ >= row_us) {
    former_delay_us_ = best_ ? row_delay_us_ : newest.delay_us;
    row_began_us_ = newest.at_us;
    row_delay_us_ = newest.delay_us;
  }
  row_delay_us_ = std::min(row_delay_us_, newest.delay_us);
  newest_us_ = newest.at_us;
  // the doubt of all trips grows alike, so that no former one becomes better than the best
  if (!best_ || doubt(newest) <= doubt(*best_)) best_ = newest;
  return true;
}

double ClockEstimate::doubt(const Trip& trip) const {
  return static_cast<double>(trip.delay_us) / 2 + most_drift_ppm * 1e-6 * static_cast<double>(newest_us_ - trip.at_us);
}

std::optional<ClockEstimate::Clock> ClockEstimate::clock() const {
  if (!best_) return {};
  return Clock{best_->offset_us, static_cast<std::int64_t>(doubt(*best_)) + 1,
               std::min(row_delay_us_, former_delay_us_)};
}

}  // namespace arkmesh::gateway
