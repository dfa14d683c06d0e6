// Robots with markers: found where they were drawn, by their numbers, in windows and in parts, and not where none is.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "hal/random.hpp"
#include "tests/support/pictures/photo_effects.hpp"
#include "tests/support/processes/run_delay.hpp"
#include "tracker/follow/marker_tracker.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;
using tracker::Calibration;
using tracker::MarkerSettings;
using tracker::MarkerTracker;

namespace {

struct Placed {
  hal::RobotId robot;
  hal::Pose pose;
};

// A camera 2 m above the middle, a little aslant.
Calibration oblique(int width_px, int height_px, double px_per_m) {
  tracker::CameraData data;
  data.lens.width_px = width_px;
  data.lens.height_px = height_px;
  data.lens.matrix = {2 * px_per_m, 0, width_px / 2.0, 0, 2 * px_per_m, height_px / 2.0, 0, 0, 1};
  const double tilt = 0.1;
  data.rotation = {1, 0, 0, 0, -std::cos(tilt), -std::sin(tilt), 0, std::sin(tilt), -std::cos(tilt)};
  data.translation_m = {0, 0, 2};
  data.arena_width_m = 2;
  data.arena_height_m = 1.5;
  return Calibration(data);
}

// What that camera sees of robots that carry these markers, four rays a pixel.
cv::Mat render(const Calibration& camera, const MarkerSettings& settings, std::span<const Placed> robots) {
  const tracker::Lens& lens = camera.data().lens;
  constexpr int finer = 4, square_px = 16;
  cv::Mat out(finer * lens.height_px, finer * lens.width_px, CV_8UC3, cv::Scalar(180, 190, 185));
  for (const Placed& robot : robots) {
    const cv::Mat marker = tracker::marker_picture(settings.family, static_cast<int>(robot.robot), square_px);
    const int squares = tracker::MarkerFinder::squares(settings.family);
    const double half_m = settings.side_m / 2 * (squares + 2) / squares;
    const double up = robot.pose.heading_rad - settings.turned_rad;  // where the printed top is
    std::vector<cv::Point2f> to, from;
    for (const auto& [x, y] : {std::pair{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}) {
      const double along = half_m * y, right = half_m * x;
      const auto pixel = camera.to_pixel({robot.pose.x_m + along * std::cos(up) + right * std::sin(up),
                                          robot.pose.y_m + along * std::sin(up) - right * std::cos(up)},
                                         settings.height_m);
      to.emplace_back(static_cast<float>(finer * (pixel->x + 0.5) - 0.5),
                      static_cast<float>(finer * (pixel->y + 0.5) - 0.5));
      from.emplace_back((x + 1) / 2.0F * static_cast<float>(marker.cols) - 0.5F,
                        (1 - y) / 2.0F * static_cast<float>(marker.rows) - 0.5F);
    }
    cv::Mat colour;
    cv::cvtColor(marker, colour, cv::COLOR_GRAY2BGR);
    const auto move = cv::getPerspectiveTransform(from, to);
    const cv::Rect box = cv::boundingRect(to) & cv::Rect(0, 0, out.cols, out.rows);
    const cv::Mat shift = (cv::Mat_<double>(3, 3) << 1, 0, -box.x, 0, 1, -box.y, 0, 0, 1);
    cv::Mat drawn, inside;
    cv::warpPerspective(colour, drawn, shift * move, box.size());
    cv::warpPerspective(cv::Mat(marker.size(), CV_8U, cv::Scalar(255)), inside, shift * move, box.size());
    drawn.copyTo(out(box), inside);
  }
  cv::resize(out, out, {lens.width_px, lens.height_px}, 0, 0, cv::INTER_AREA);
  return out;
}

// Looks at the same picture, some time apart, until every part of it was searched.
std::vector<hal::Observation> found_in(MarkerTracker& tracker, const cv::Mat& picture, hal::LabTime& now) {
  std::vector<hal::Observation> out;
  for (int i = 0; i < 12; ++i) out = tracker.look(now += hal::LabTime{100'000}, std::span(&picture, 1));
  return out;
}

void check_places(std::span<const hal::Observation> seen, std::span<const Placed> robots) {
  REQUIRE(seen.size() == robots.size());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    CAPTURE(robots[i].robot);
    CHECK(seen[i].robot == robots[i].robot);
    CHECK(std::hypot(seen[i].pose.x_m - robots[i].pose.x_m, seen[i].pose.y_m - robots[i].pose.y_m) < 0.001);
    CHECK(std::abs(std::remainder(seen[i].pose.heading_rad - robots[i].pose.heading_rad, 2 * std::numbers::pi)) < 0.03);
    CHECK(seen[i].led == hal::Led::unknown);
  }
}

std::vector<Placed> in_rows(int robots, double width_m, double height_m) {
  std::vector<Placed> out;
  const int columns = 4, rows = (robots + 3) / 4;
  for (int i = 0; i < robots; ++i)
    out.push_back({static_cast<hal::RobotId>(i + 1),
                   {width_m * ((i % columns + 0.5) / columns - 0.5), height_m * ((i / columns + 0.5) / rows - 0.5),
                    std::remainder(0.7 * i, 2 * std::numbers::pi)}});
  return out;
}

MarkerSettings settings_for(std::span<const Placed> robots) {
  MarkerSettings out;
  out.height_m = 0.06;
  out.turned_rad = 0.5;
  for (const Placed& robot : robots) out.robots.push_back(robot.robot);
  return out;
}

}  // namespace

TEST_CASE("markers: each robot where it is, by its number") {
  // Robots of every family of markers are found within 1 mm and 2 degrees, under an oblique camera and in noise.
  const std::vector<Placed> robots = in_rows(7, 1.2, 0.8);
  for (const std::string& family : tracker::MarkerFinder::families()) {
    CAPTURE(family);
    MarkerSettings settings = settings_for(robots);
    settings.family = family;
    const Calibration camera = oblique(1024, 768, 600);
    cv::Mat picture = render(camera, settings, robots);
    add_noise(picture, 4, 1);
    MarkerTracker tracker({camera}, settings);
    CHECK(tracker.missing().size() == 7);
    hal::LabTime now{0};
    check_places(found_in(tracker, picture, now), robots);
    CHECK(tracker.missing().empty());
  }
}

TEST_CASE("markers: followed, lost and found again") {
  // Robots that drive at their top speed and turn are in every frame; one that is taken away is missing, and back where
  // it is put; two cameras see the same robots once.
  std::vector<Placed> robots = in_rows(6, 1.2, 0.8);
  const MarkerSettings settings = settings_for(robots);
  const Calibration left = oblique(800, 600, 450), right = oblique(800, 600, 420);
  MarkerTracker tracker({left, right}, settings);
  hal::LabTime now{0};
  for (int n = 0; n < 40; ++n) {
    for (Placed& robot : robots) {
      robot.pose.x_m += 0.02 * (n / 10 % 2 == 0 ? 1 : -1);
      robot.pose.heading_rad = std::remainder(robot.pose.heading_rad + 0.2, 2 * std::numbers::pi);
    }
    std::vector<Placed> there = robots;
    if (n >= 20 && n < 30) there.erase(there.begin() + 2);
    const std::vector<cv::Mat> pictures{render(left, settings, there),
                                        n % 3 ? render(right, settings, there) : cv::Mat()};
    const auto seen = tracker.look(now += hal::LabTime{100'000}, pictures);
    if (n < 5 || (n >= 30 && n < 34)) continue;
    CAPTURE(n);
    check_places(seen, there);
    CHECK(tracker.missing() == (there.size() < 6 ? std::vector<hal::RobotId>{3} : std::vector<hal::RobotId>()));
  }
}

TEST_CASE("markers: what is no robot's") {
  // A marker of nobody, of another size, or twice in one picture is refused and counted; a blurred one is missing.
  const std::vector<Placed> robots = in_rows(3, 0.8, 0.6);
  MarkerSettings settings = settings_for(std::span(robots).first(2));
  const Calibration camera = oblique(800, 600, 450);
  hal::LabTime now{0};
  MarkerTracker tracker({camera}, settings);
  check_places(found_in(tracker, render(camera, settings, robots), now), std::span(robots).first(2));
  CHECK(tracker.counters()["marker.refused.unknown"] > 0);

  std::vector<Placed> twice(robots.begin(), robots.end());
  twice[2].robot = 1;
  MarkerTracker of_twice({camera}, settings);
  CHECK(found_in(of_twice, render(camera, settings, twice), now).size() <= 2);
  MarkerSettings other = settings;
  other.side_m = 0.09;
  MarkerTracker of_others({camera}, settings);
  CHECK(found_in(of_others, render(camera, other, robots), now).empty());
  CHECK(of_others.counters()["marker.refused.size"] > 0);

  cv::Mat blurred = render(camera, settings, robots);
  motion_blur(blurred, 9, 20);
  CHECK(found_in(tracker, blurred, now).empty());
  CHECK(tracker.missing().size() == 2);
  const cv::Mat small(300, 400, CV_8UC3, cv::Scalar::all(0));
  CHECK(tracker.look(now, std::span(&small, 1)).empty());
  CHECK(tracker.counters()["camera.refused.size"] == 1);
  CHECK(MarkerTracker::largest_speed_m_s(settings, 0.01) == doctest::Approx(0.625));
}

TEST_CASE("markers: twelve are followed in each of thirty pictures, and what that takes is printed") {
  const std::vector<Placed> robots = in_rows(12, 1.8, 1.2);
  const MarkerSettings settings = settings_for(robots);
  const Calibration camera = oblique(2048, 1536, 800);
  const cv::Mat picture = render(camera, settings, robots);
  MarkerTracker tracker({camera}, settings);
  hal::LabTime now{0};
  check_places(found_in(tracker, picture, now), robots);
  cv::setNumThreads(1);
  std::vector<double> took_ms;
  for (int n = 0; n < 30; ++n) {
    const OwnTime own;
    CHECK(tracker.look(now += hal::LabTime{100'000}, std::span(&picture, 1)).size() == 12);
    took_ms.push_back(std::chrono::duration<double, std::milli>(own.passed()).count());
  }
  cv::setNumThreads(-1);
  std::ranges::sort(took_ms);
  MESSAGE("median ", took_ms[15], " ms a frame");
}
