// Following robots through windows, and pictures that show none or are none.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <span>
#include <stdexcept>
#include <utility>

#include "testbed/kilobot_tracking.hpp"
#include "tests/support/pictures/robot_pictures.hpp"
#include "tracker/detect/detector.hpp"

namespace arkmesh::tests {
namespace {

std::vector<tracker::Expected> moved(const Scene& scene, double by_radii, double reach_radii) {
  std::vector<tracker::Expected> where;
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const TrueRobot& robot = scene.robots[i];
    const double angle = 2.4 * static_cast<double>(i), far = by_radii * robot.r_px;
    where.push_back(
        {robot.x_px + far * std::cos(angle), robot.y_px + far * std::sin(angle), robot.r_px, reach_radii * robot.r_px});
  }
  return where;
}

TEST_CASE("follow finds what search finds") {
  // Proves: near or half a radius away, each expected robot is found at its own index and as well as by a search of
  // everything.
  for (const double by_radii : {0.0, 0.15, 0.5})
    for (const Scene& scene : real_scenes()) {
      const auto seen = tracker::Detector().follow(scene.bgr, moved(scene, by_radii, by_radii + 0.2));
      REQUIRE(seen.size() == scene.robots.size());
      int right = 0;
      double off_px = 0;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (!seen[i]) continue;
        const double off = std::hypot(seen[i]->x_px - scene.robots[i].x_px, seen[i]->y_px - scene.robots[i].y_px);
        if (off < 0.2 * scene.robots[i].r_px) ++right, off_px += off;
      }
      CAPTURE(scene.name);
      CAPTURE(by_radii);
      CHECK(right >= 0.95 * static_cast<double>(seen.size()));
      CHECK(off_px < 1.0 * right);
    }
}

TEST_CASE("follow gives one robot to one place") {
  // Proves: of two places that see the same robot the nearer one gets it; an empty place and one out of reach get
  // nothing.
  const Scene scene = real_scenes()[1];
  const TrueRobot& robot = scene.robots[0];
  const std::vector<tracker::Expected> where = {{robot.x_px + 8, robot.y_px, robot.r_px, robot.r_px},
                                                {robot.x_px + 2, robot.y_px, robot.r_px, robot.r_px},
                                                {760, 200, robot.r_px, 10},
                                                {robot.x_px, robot.y_px + 15, robot.r_px, 5}};
  const auto seen = tracker::Detector().follow(scene.bgr, where);
  REQUIRE(seen.size() == 4);
  CHECK(!seen[0]);
  REQUIRE(seen[1]);
  CHECK(std::abs(seen[1]->x_px - robot.x_px) < 2);
  CHECK(!seen[2]);
  CHECK(!seen[3]);
}

TEST_CASE("follow survives any place") {
  // Proves: places far outside, without size or not numbers at all are nothing seen, without harm.
  const Scene scene = real_scenes()[1];
  const double none = std::numeric_limits<double>::quiet_NaN(), endless = std::numeric_limits<double>::infinity();
  const std::vector<tracker::Expected> where = {
      {-1e9, 5, 20, 5},    {5, 1e300, 20, 5}, {none, 5, 20, 5}, {5, 5, none, 5}, {5, 5, 20, none},  {5, 5, endless, 5},
      {5, 5, 20, endless}, {5, 5, 0, 5},      {5, 5, -20, 5},   {5, 5, 20, -5},  {853, 479, 20, 1}, {-20, -20, 22, 3}};
  for (const auto& seen : tracker::Detector().follow(scene.bgr, where)) CHECK(!seen);
  CHECK(tracker::Detector().follow(scene.bgr, {}).empty());
}

TEST_CASE("pictures without robots") {
  // Proves: nothing is invented on plain, noisy, chequered and tiny pictures, whatever the size asked for.
  cv::Mat noise(480, 640, CV_8UC3), chess(480, 640, CV_8UC3, cv::Scalar::all(220)),
      lines(480, 640, CV_8UC3, cv::Scalar::all(180));
  cv::RNG(5).fill(noise, cv::RNG::UNIFORM, 0, 256);
  for (int y = 0; y < 12; ++y)
    for (int x = y % 2; x < 16; x += 2)
      cv::rectangle(chess, cv::Rect(40 * x, 40 * y, 40, 40), cv::Scalar::all(20), cv::FILLED);
  for (int i = 0; i < 30; ++i)
    cv::line(lines, cv::Point(i * 37 % 640, 0), cv::Point(i * 91 % 640, 479), cv::Scalar::all(30), 1 + i % 7,
             cv::LINE_AA);
  std::vector<cv::Mat> pictures = {noise, chess, lines};
  for (const int level : {0, 128, 255}) pictures.emplace_back(480, 640, CV_8UC3, cv::Scalar::all(level));
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(3, 2000), cv::Size(2000, 3), cv::Size(16, 16)})
    pictures.emplace_back(size, CV_8UC3, cv::Scalar::all(99));
  for (const cv::Mat& bgr : pictures)
    for (const double diameter_px : {0.0, 12.0, 45.0, 3000.0}) {
      tracker::DetectorSettings settings;
      if (diameter_px > 0) settings.diameter_px = diameter_px;
      CAPTURE(bgr.cols);
      CAPTURE(diameter_px);
      CHECK(tracker::Detector(settings).search(bgr).empty());
    }
}

TEST_CASE("the size is remembered") {
  // Proves: the size found in one picture serves the next, and is found anew when the camera has been moved.
  const Scene scene = real_scenes()[2], smaller = resized(scene, 0.5);
  tracker::Detector detector;
  CHECK(!detector.diameter_px());
  CHECK(detector.search(scene.bgr).size() == 28);
  REQUIRE(detector.diameter_px());
  CHECK(*detector.diameter_px() == doctest::Approx(45).epsilon(0.03));
  CHECK(score(detector.search(smaller.bgr), smaller.robots).recall() == 1.0);
  CHECK(*detector.diameter_px() == doctest::Approx(22.5).epsilon(0.03));
}

TEST_CASE("searches of an unchanged picture miss nothing that comes") {
  // Proves: however often the same was seen before, a robot more is found by the next search, also where another left;
  // and what is seen stays the same meanwhile.
  const Scene scene = real_scenes()[2];
  const auto without = [&](std::size_t gone) {
    Scene less = scene;
    less.bgr = scene.bgr.clone();
    const TrueRobot& robot = scene.robots[gone];
    const cv::Point at(cvRound(robot.x_px), cvRound(robot.y_px));
    cv::circle(less.bgr, at, cvRound(1.2 * robot.r_px), cv::mean(scene.bgr), cv::FILLED);
    less.robots.erase(less.robots.begin() + static_cast<std::ptrdiff_t>(gone));
    return less;
  };
  const Scene first = without(3), second = without(9);
  for (int before = 1; before < 9; ++before) {
    CAPTURE(before);
    tracker::Detector detector;
    for (int i = 0; i < before; ++i) {
      const Score seen = score(detector.search(first.bgr), first.robots);
      CHECK(seen.recall() == 1.0);
      CHECK(seen.precision() == 1.0);
    }
    CHECK(score(detector.search(before % 2 ? scene.bgr : second.bgr), before % 2 ? scene.robots : second.robots)
              .recall() == 1.0);
  }
}

TEST_CASE("the same picture gives the same robots") {
  // Proves: results do not depend on what was looked at before or on chance.
  const Scene scene = real_scenes()[5];
  tracker::DetectorSettings settings;
  settings.diameter_px = 45;
  tracker::Detector one(settings), other(settings);
  other.search(real_scenes()[0].bgr);
  const auto first = one.search(scene.bgr), second = other.search(scene.bgr);
  REQUIRE(first.size() == second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].x_px == second[i].x_px);
    CHECK(first[i].confidence == second[i].confidence);
    CHECK(first[i].led == second[i].led);
  }
}

TEST_CASE("only 8-bit BGR pictures") {
  // Proves: other kinds of picture are refused with a sentence.
  tracker::Detector detector;
  CHECK_THROWS_AS(detector.search(cv::Mat()), std::invalid_argument);
  CHECK_THROWS_AS(detector.search(cv::Mat(10, 10, CV_8UC1)), std::invalid_argument);
  CHECK_THROWS_AS(detector.follow(cv::Mat(10, 10, CV_16UC3), {}), std::invalid_argument);
}

TEST_CASE("what lies outside the arena by more than a radius is no robot") {
  // Proves that a calibrated arena drops and counts it, here the outer three of six, and that one without drops none.
  const Scene scene = real_scenes().front();
  const double metres_per_px = hal::kilobot::body_radius_m / scene.robots[0].r_px;
  std::vector<double> off_px;
  for (const TrueRobot& robot : scene.robots) off_px.push_back(std::abs(robot.x_px - (scene.bgr.cols - 1) / 2.0));
  std::sort(off_px.begin(), off_px.end());
  REQUIRE(off_px.size() == 6);
  REQUIRE(off_px[3] - off_px[2] > 4);
  const auto camera = tracker::Calibration::overhead(scene.bgr.cols, scene.bgr.rows, metres_per_px);
  tracker::CameraData narrow = camera.data();
  narrow.arena_width_m = (off_px[2] + off_px[3]) * metres_per_px - 2 * hal::kilobot::body_radius_m;
  for (const auto& [calibration, outside] : {std::pair(camera, 0u), {tracker::Calibration(narrow), 3u}}) {
    tracker::ArenaTracker tracking({calibration}, testbed::kilobot_tracking());
    tracking.look(hal::LabTime{0}, std::span(&scene.bgr, 1));
    CHECK(tracking.detections(0).size() == 6);
    CHECK(tracking.counters()["seen.outside"] == outside);
    CHECK(tracking.counters()["track.born"] == 6 - outside);
  }
}

}  // namespace
}  // namespace arkmesh::tests
