// The filter of one robot's motion: heading from the LED, from the path, on the spot, and after wrong lights.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "testbed/kilobot_tracking.hpp"
#include "tracker/follow/motion.hpp"

using namespace arkmesh;
using tracker::Motion;
using tracker::wrapped;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double frame_s = 0.1;
const tracker::MotionSettings kilobot = testbed::kilobot_following().motion;

// The truth: a Kilobot whose rear axle's middle drives at a speed and turns at a rate.
struct Walker {
  double x_m = 0, y_m = 0, heading_rad = 0;
  std::mt19937_64 random{11};

  void walk(double speed_m_s, double turn_rad_s) {
    for (int i = 0; i < 20; ++i) {
      const double dt = frame_s / 20;
      x_m += (speed_m_s * std::cos(heading_rad) - hal::kilobot::rear_axle_m * turn_rad_s * std::sin(heading_rad)) * dt;
      y_m += (speed_m_s * std::sin(heading_rad) + hal::kilobot::rear_axle_m * turn_rad_s * std::cos(heading_rad)) * dt;
      heading_rad = wrapped(heading_rad + turn_rad_s * dt);
    }
  }
  double noise(double sigma) { return std::normal_distribution<>(0, sigma)(random); }
  void show_place(Motion& motion) {
    const double y = y_m + noise(0.0005);
    motion.see_place(x_m + noise(0.0005), y, 0.0005);
  }
  double off_degrees(const Motion& motion) const {
    return std::abs(wrapped(motion.pose().heading_rad - heading_rad)) / degree;
  }
};

void frame(Walker& walker, Motion& motion, double speed_m_s, double turn_rad_s) {
  walker.walk(speed_m_s, turn_rad_s);
  motion.predict(frame_s);
  walker.show_place(motion);
}

}  // namespace

TEST_CASE("angles wrap into (-pi, pi]") {
  // Proves the edges of the circle.
  CHECK(wrapped(std::numbers::pi) == doctest::Approx(std::numbers::pi));
  CHECK(wrapped(-std::numbers::pi) == doctest::Approx(std::numbers::pi));
  CHECK(wrapped(3 * std::numbers::pi) == doctest::Approx(std::numbers::pi));
  CHECK(wrapped(0.5 + 20 * std::numbers::pi) == doctest::Approx(0.5));
}

TEST_CASE("a robot that stands still without LED has no heading") {
  // Proves that nothing is made up from noise.
  Walker walker;
  Motion motion(0, 0, 0.0005, kilobot);
  for (int i = 0; i < 600; ++i) frame(walker, motion, 0, 0);
  CHECK(motion.heading_sigma_rad() == doctest::Approx(std::numbers::pi));
  CHECK(std::hypot(motion.pose().x_m, motion.pose().y_m) < 0.0015);
}

TEST_CASE("a path tells the heading without LED") {
  // Proves that after a few centimetres straight on, in any direction, the heading is right and known to be.
  for (int direction = -170; direction <= 180; direction += 25) {
    Walker walker{.heading_rad = direction * degree};
    Motion motion(0, 0, 0.0005, kilobot);
    for (int i = 0; i < 60; ++i) frame(walker, motion, 0.01, 0);
    CAPTURE(direction);
    CHECK(walker.off_degrees(motion) < 10);
    CHECK(motion.heading_sigma_rad() < 20 * degree);
    CHECK(motion.speed_m_s() == doctest::Approx(0.01).epsilon(0.2));
  }
}

TEST_CASE("turning on the spot is followed while the LED is dark") {
  // Proves that a full turn about a rear leg, seen only by the centre's small circle, ends with the right heading.
  for (const double rate : {0.6, -0.6}) {
    Walker walker;
    Motion motion(0, 0, 0.0005, kilobot);
    motion.see_heading(0, 5 * degree);
    double worst = 0;
    for (int i = 0; i < 105; ++i) {
      frame(walker, motion, std::abs(rate) * 0.0138, rate);
      worst = std::max(worst, walker.off_degrees(motion));
    }
    CAPTURE(rate);
    CHECK(worst < 40);
    CHECK(walker.off_degrees(motion) < 20);
  }
}

TEST_CASE("the LED gives the heading within its noise, turning or not") {
  // Proves an error well below that of a single look, and no lag in a turn.
  Walker walker;
  Motion motion(0, 0, 0.0005, kilobot);
  double square = 0;
  int n = 0;
  for (int i = 0; i < 1000; ++i) {
    const double turn = i % 200 < 100 ? 0.7 : 0;
    frame(walker, motion, 0.01, turn);
    motion.see_heading(walker.heading_rad + walker.noise(6 * degree), 6 * degree);
    if (i < 5) continue;
    square += std::pow(walker.off_degrees(motion), 2);
    ++n;
  }
  CHECK(std::sqrt(square / n) < 4.5);
}

TEST_CASE("one light of a neighbour does not turn a robot, three do") {
  // Proves that outliers are passed over, and that a robot turned by hand is believed soon.
  Walker walker;
  Motion motion(0, 0, 0.0005, kilobot);
  for (int i = 0; i < 20; ++i) {
    frame(walker, motion, 0, 0);
    motion.see_heading(walker.noise(3 * degree), 3 * degree);
  }
  frame(walker, motion, 0, 0);
  motion.see_heading(120 * degree, 3 * degree);
  CHECK(walker.off_degrees(motion) < 5);
  for (int i = 0; i < 3; ++i) {
    frame(walker, motion, 0, 0);
    motion.see_heading(120 * degree, 3 * degree);
  }
  CHECK(motion.pose().heading_rad == doctest::Approx(120 * degree).epsilon(0.05));
}

TEST_CASE("a heading that is the wrong way round is corrected by driving") {
  // Proves that a robot that seems to drive backwards is turned round.
  Walker walker;
  Motion motion(0, 0, 0.0005, kilobot);
  motion.see_heading(std::numbers::pi, 5 * degree);
  for (int i = 0; i < 100; ++i) frame(walker, motion, 0.01, 0);
  CHECK(walker.off_degrees(motion) < 12);
}

TEST_CASE("the last heading fades while nothing is seen") {
  // Proves that uncertainty grows until nothing is claimed, and that the filter stays finite.
  Motion motion(0, 0, 0.0005, kilobot);
  motion.see_heading(1, 3 * degree);
  double before = motion.heading_sigma_rad();
  for (int i = 0; i < 5; ++i) {
    motion.predict(0.3);
    CHECK(motion.heading_sigma_rad() >= before);
    before = motion.heading_sigma_rad();
  }
  motion.predict(1e6);
  CHECK(motion.heading_sigma_rad() == doctest::Approx(std::numbers::pi));
  CHECK(std::isfinite(motion.pose().x_m));
}

TEST_CASE("a robot that a wall holds in the dark loses its heading, and says so") {
  // Proves that what a wall does to a robot is not taken for what its motors do: it turns while its centre stands.
  for (const bool touching : {true, false}) {
    Walker walker;
    Motion motion(0, 0, 0.0005, kilobot);
    motion.see_heading(0, 5 * degree);
    for (int i = 0; i < 30; ++i) frame(walker, motion, 0.01, 0);
    double worst = 0;
    for (int i = 0; i < 40; ++i) {
      walker.heading_rad = wrapped(walker.heading_rad + 0.4 * frame_s);
      motion.predict(frame_s, touching);
      walker.show_place(motion);
      worst = std::max(worst, walker.off_degrees(motion) * degree / motion.heading_sigma_rad());
    }
    CAPTURE(touching);
    CAPTURE(worst);
    CHECK((worst < 2.5) == touching);
  }
}

TEST_CASE("a robot that is pushed backwards is not taken for one seen the wrong way round") {
  // Proves that only a robot that touches nothing is turned round: Kilobots do not drive backwards by themselves.
  for (const bool touching : {true, false}) {
    Walker walker;
    Motion motion(0, 0, 0.0005, kilobot);
    motion.see_heading(0, 5 * degree);
    for (int i = 0; i < 30; ++i) {
      walker.x_m -= 0.01 * frame_s;
      motion.predict(frame_s, touching);
      walker.show_place(motion);
    }
    CAPTURE(touching);
    CHECK((walker.off_degrees(motion) < 60) == touching);
  }
}
