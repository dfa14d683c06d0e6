// Readings that are a little wrong, and renewed now and then.
#include "scenarios/kit/readings.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace arkmesh::scenarios::kit {
namespace {

using Column = Readings::Column;

hal::PoseFrame frame_at(double seconds, int robots) {
  hal::PoseFrame frame;
  frame.stamp = hal::LabTime{std::llround(seconds * 1e6)};
  for (int i = 0; i < robots; ++i) frame.robots.push_back({static_cast<hal::RobotId>(i), {}});
  return frame;
}

}  // namespace

TEST_CASE("kit: noise has its mean and deviation, keeps to its bounds, and leaves what is none") {
  Readings readings(0, {{Column::Kind::number, 0, 100, 0.5}, {Column::Kind::whole_number, 0, 3, 1}}, 7, "a/kit/0");
  double sum = 0, squares = 0;
  constexpr int rounds = 20'000;
  for (int i = 0; i < rounds; ++i) {
    double two[] = {10, 1, -1, -1};
    readings.pass(frame_at(0.1 * i, 2), two);
    sum += two[0] - 10;
    squares += (two[0] - 10) * (two[0] - 10);
    REQUIRE(two[1] == std::round(two[1]));
    REQUIRE((0 <= two[1] && two[1] <= 3));
    REQUIRE((two[2] == -1 && two[3] == -1));
  }
  CHECK(sum / rounds == doctest::Approx(0).epsilon(0.02));
  CHECK(std::sqrt(squares / rounds) == doctest::Approx(0.5).epsilon(0.03));
}

TEST_CASE("kit: an angle with noise turns round") {
  Readings readings(0, {{Column::Kind::angle, 0, 0, 0.3}}, 7, "a/kit/0");
  int negative = 0;
  for (int i = 0; i < 1000; ++i) {
    double angle[] = {std::numbers::pi - 0.01};
    readings.pass(frame_at(0.1 * i, 1), angle);
    REQUIRE(std::abs(angle[0]) <= std::numbers::pi);
    negative += angle[0] < 0;
  }
  CHECK(negative > 400);
  CHECK(negative < 600);
}

TEST_CASE("kit: readings are held between their times, and a new robot has one at once") {
  Readings readings(1, {{Column::Kind::number, 0, 100, 0}}, 7, "a/kit/0");
  for (int i = 0; i <= 30; ++i) {
    double value[] = {static_cast<double>(i), static_cast<double>(i)};
    readings.pass(frame_at(0.1 * i, i < 15 ? 1 : 2), std::span(value).first(i < 15 ? 1 : 2));
    CHECK(value[0] == i / 10 * 10);
    if (i >= 15) CHECK(value[1] == (i < 20 ? 15 : i / 10 * 10));
  }
}

TEST_CASE("kit: readings that make no sense are refused in one sentence") {
  CHECK_THROWS_WITH_AS(Readings(-1, {}, 1, "x"), "readings every -1 s are not possible; give 0 to 1e6 s",
                       std::invalid_argument);
  CHECK_THROWS_WITH(Readings(0, {{Column::Kind::angle, 0, 0, std::numeric_limits<double>::infinity()}}, 1, "x"),
                    "noise of inf is not possible; give 0 or more");
}

}  // namespace arkmesh::scenarios::kit
