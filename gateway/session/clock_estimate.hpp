// What a peer's clock shows beside ours, from heartbeats that go there and back. The quickest ones count, for what a
// network adds it adds at random. Pure.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace arkmesh::gateway {

// A monotonic clock, and how far the wall clock is ahead of it now; microseconds.
std::int64_t monotonic_us(std::chrono::steady_clock::time_point at);
std::int64_t wall_ahead_us(std::chrono::steady_clock::time_point at);

// One heartbeat there and one back, in microseconds; the middle two by the peer's monotonic clock.
struct RoundTrip {
  std::int64_t sent_us = 0, peer_heard_us = 0, peer_sent_us = 0, heard_us = 0;
};

class ClockEstimate {
 public:
  // False when it cannot be: what comes back before it went out, or was held longer than it was away.
  bool add(const RoundTrip& trip);

  struct Clock {
    std::int64_t offset_us = 0;       // the peer's monotonic clock less ours, at the newest trip
    std::int64_t uncertainty_us = 0;  // it is not further off than this, as long as the path there is the path back
    std::int64_t round_trip_us = 0;   // the least of late
  };
  // Nothing before the first trip.
  std::optional<Clock> clock() const;

 private:
  struct Trip {
    std::int64_t at_us, offset_us, delay_us;
  };
  // How far the offset now may be from that of a trip, in microseconds.
  double doubt(const Trip& trip) const;

  std::optional<Trip> best_;  // tells most of the offset now
  std::int64_t newest_us_ = 0;
  std::int64_t row_began_us_ = 0;
  std::int64_t row_delay_us_ = 0, former_delay_us_ = 0;  // the least of ten seconds, and of those before
};

}  // namespace arkmesh::gateway
