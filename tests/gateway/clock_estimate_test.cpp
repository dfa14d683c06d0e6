// What is known of a peer's clock, against clocks that the test makes.
#include "gateway/session/clock_estimate.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "hal/random.hpp"

namespace arkmesh::gateway {
namespace {

TEST_CASE("the offset is found through a network that is late by chance") {
  // Heartbeats for ten minutes, 5 to 200 ms late each way, between clocks that are 3 s apart and drift: the truth is
  // always within the uncertainty, which becomes a few milliseconds.
  for (const double drift_ppm : {0.0, 40.0, -80.0}) {
    CAPTURE(drift_ppm);
    hal::RandomStream random(11, "clock");
    const auto peer_clock = [&](double us) { return std::llround(3e6 + us * (1 + drift_ppm * 1e-6)); };
    const auto late_us = [&] { return 5000 + 195'000 * std::pow(random.uniform(0, 1), 3); };
    ClockEstimate estimate;
    CHECK_FALSE(estimate.clock());
    for (double at = 1e6; at < 600e6; at += 500'000) {
      const double there = at + late_us(), back = there + 300'000, here = back + late_us();
      CHECK(estimate.add({std::llround(at), peer_clock(there), peer_clock(back), std::llround(here)}));
      const auto clock = estimate.clock();
      REQUIRE(clock);
      CHECK(std::abs(static_cast<double>(clock->offset_us) - (static_cast<double>(peer_clock(here)) - here)) <=
            static_cast<double>(clock->uncertainty_us));
    }
    const auto clock = estimate.clock();
    CHECK(clock->uncertainty_us < 8000);
    CHECK(clock->round_trip_us < 40'000);
  }
}

TEST_CASE("heartbeats that cannot be are refused") {
  // What came back before it went out, was held longer than it was away, or is of another world changes nothing.
  ClockEstimate estimate;
  constexpr std::int64_t far = INT64_MAX;
  for (const RoundTrip& trip :
       {RoundTrip{100, 50, 60, 90}, RoundTrip{100, 50, 40, 200}, RoundTrip{100, 50, 200, 200},
        RoundTrip{100, 0, far, 200}, RoundTrip{-far, 0, 0, far}, RoundTrip{100, 0, 0, 4'000'000'000}})
    CHECK_FALSE(estimate.add(trip));
  CHECK_FALSE(estimate.clock());
  CHECK(estimate.add({100, 1050, 1060, 200}));
  CHECK_FALSE(estimate.add({80, 1050, 1060, 190}));
  CHECK(estimate.clock()->offset_us == 905);
  CHECK(estimate.clock()->round_trip_us == 90);
}

}  // namespace
}  // namespace arkmesh::gateway
