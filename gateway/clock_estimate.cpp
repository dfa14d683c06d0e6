// The quickest trip of each ten seconds; offset from the best of the newest, drift between the two halves.
#include "gateway/clock_estimate.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>

namespace arkmesh::gateway {
namespace {

// What clocks of computers drift apart at most before the drift is known.
constexpr double unknown_drift_ppm = 100;
constexpr std::int64_t least_span_us = 60'000'000;
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
  const Best best{trip.heard_us, ((trip.peer_heard_us - trip.sent_us) + (trip.peer_sent_us - trip.heard_us)) / 2,
                  away - held};
  newest_us_ = trip.heard_us;
  if (rows_.empty() || trip.heard_us - row_began_us_ >= row_us) {
    row_began_us_ = trip.heard_us;
    rows_.push_back(best);
    if (rows_.size() > rows) rows_.pop_front();
  } else if (best.delay_us <= rows_.back().delay_us) {
    rows_.back() = best;
  }
  return true;
}

std::optional<ClockEstimate::Clock> ClockEstimate::clock() const {
  if (rows_.empty()) return {};
  Clock out;
  const auto quicker = [](const Best& a, const Best& b) { return a.delay_us < b.delay_us; };
  double unknown_ppm = unknown_drift_ppm;
  if (rows_.back().at_us - rows_.front().at_us >= least_span_us) {
    const auto middle = rows_.begin() + static_cast<std::ptrdiff_t>(rows_.size() / 2);
    const Best early = *std::min_element(rows_.begin(), middle, quicker);
    const Best late = *std::min_element(middle, rows_.end(), quicker);
    const auto span = static_cast<double>(late.at_us - early.at_us);
    out.drift_ppm = 1e6 * static_cast<double>(late.offset_us - early.offset_us) / span;
    unknown_ppm = std::min(unknown_ppm, 1e6 * static_cast<double>(late.delay_us + early.delay_us) / 2 / span);
  }
  // Of the newest rows the one that says most about now: half its delay, and what may have changed since.
  const auto doubt = [&](const Best& best) {
    return static_cast<double>(best.delay_us) / 2 + unknown_ppm * 1e-6 * static_cast<double>(newest_us_ - best.at_us);
  };
  const Best best =
      *std::min_element(rows_.begin(), rows_.end(), [&](const Best& a, const Best& b) { return doubt(a) < doubt(b); });
  const double since = static_cast<double>(newest_us_ - best.at_us);
  out.offset_us = best.offset_us + static_cast<std::int64_t>(out.drift_ppm * 1e-6 * since);
  out.uncertainty_us = static_cast<std::int64_t>(doubt(best)) + 1;
  const std::size_t recent = std::min<std::size_t>(rows_.size(), 2);
  out.round_trip_us =
      std::min_element(rows_.end() - static_cast<std::ptrdiff_t>(recent), rows_.end(), quicker)->delay_us;
  return out;
}

}  // namespace arkmesh::gateway
