// When a recording grows too fast, by which clock, and because of what.
#include "hal/record/growth_watch.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace arkmesh;
using namespace std::chrono_literals;
using hal::GrowthWatch;

namespace {

// 100 messages of 1000 bytes, these steps apart; what was told last.
std::optional<GrowthWatch::Growth> told(GrowthWatch::Time lab_step, GrowthWatch::Time wall_step) {
  GrowthWatch watch(5000);
  std::optional<GrowthWatch::Growth> growth;
  for (int i = 0; i < 100; ++i)
    if (auto now = watch.add(i * lab_step, i * wall_step, "poses", 1000)) growth = now;
  return growth;
}

}  // namespace

TEST_CASE("growth: the clock that went further counts") {
  CHECK_FALSE(told(1s, 1ms));  // a fast simulation
  CHECK_FALSE(told(0s, 1s));   // a lab that waits
  const auto growth = told(0s, 150ms);
  REQUIRE(growth);
  CHECK(growth->bytes_per_s > 6000);
  CHECK(growth->bytes_per_s < 7000);
  CHECK(growth->share == 1);
}

TEST_CASE("growth: names that somebody makes up are watched up to a number") {
  GrowthWatch watch(10);
  for (int i = 0; i < 100'000; ++i) REQUIRE_FALSE(watch.add(0s, 0s, "x" + std::to_string(i), 1));
  const auto growth = watch.add(0s, 10s, "roark/cam", 100'000);
  REQUIRE(growth);
  CHECK(growth->bytes_per_s == doctest::Approx(20'000));
  CHECK(growth->share < 0.01);  // of one of those that are watched
}
