// Whether a camera still hangs where it did, told from marks on the arena.
#include "tracker/camera/camera_guard.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "hal/random.hpp"

using namespace arkmesh;
using namespace arkmesh::tracker;
using Verdict = CameraGuard::Verdict;

namespace {

// An arena with specks and a border, 1 mm a pixel, as seen when the camera has gone by (x, y) pixels and turned;
// another noise each time.
cv::Mat arena(double x_px = 0, double y_px = 0, double turn_deg = 0, double light = 1, std::uint64_t noise = 1) {
  cv::Mat out(480, 640, CV_8UC3, cv::Scalar(150, 150, 150));
  cv::rectangle(out, {40, 30}, {600, 450}, cv::Scalar(90, 95, 100), 6);
  hal::RandomStream chance(5, "specks");
  for (int i = 0; i < 60; ++i) {
    const cv::Point at(static_cast<int>(chance.uniform(20, 620)), static_cast<int>(chance.uniform(20, 460)));
    cv::rectangle(out, at, at + cv::Point(6, 4), cv::Scalar::all(chance.uniform(60, 220)), cv::FILLED);
  }
  cv::GaussianBlur(out, out, {}, 1);
  cv::Mat warp = cv::getRotationMatrix2D({319.5F, 239.5F}, turn_deg, 1);
  warp.at<double>(0, 2) += x_px, warp.at<double>(1, 2) += y_px;
  cv::warpAffine(out, out, warp, out.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  out *= light;
  cv::RNG rng(noise);
  cv::Mat grain(out.size(), CV_16SC3), wide;
  rng.fill(grain, cv::RNG::NORMAL, 0, 2);
  out.convertTo(wide, CV_16SC3);
  cv::Mat(wide + grain).convertTo(out, CV_8UC3);
  return out;
}

Calibration above() {
  return Calibration::overhead(640, 480, 0.001);
}

}  // namespace

TEST_CASE("camera guard: what leaves a camera in place") {
  // Noise, other light, robots that walk over half of the marks and a hand over a third of the picture are no move.
  const Calibration calibration = above();
  CameraGuard guard;
  CHECK_FALSE(guard.has_learnt());
  guard.learn(find_landmarks(arena(), {}, calibration), calibration);
  REQUIRE(guard.marks() > 25);
  std::uint64_t noise = 2;
  for (const double light : {1.0, 0.5, 0.8, 1.3})
    CHECK(guard.look(arena(0, 0, 0, light, ++noise), calibration) == Verdict::in_place);
  hal::RandomStream chance(6, "robots");
  for (int k = 0; k < 20; ++k) {
    cv::Mat busy = arena(0, 0, 0, 1, ++noise);
    for (int i = 0; i < 60; ++i) {
      const cv::Point at(static_cast<int>(chance.uniform(0, 640)), static_cast<int>(chance.uniform(0, 480)));
      cv::circle(busy, at, 16, cv::Scalar(40, 45, 40), cv::FILLED, cv::LINE_AA);
    }
    CHECK(guard.look(busy, calibration) == Verdict::in_place);
  }
  cv::Mat hand = arena(0, 0, 0, 1, ++noise);
  hand(cv::Rect(200, 0, 213, 480)).setTo(cv::Scalar(120, 150, 200));
  CHECK(guard.look(hand, calibration) == Verdict::in_place);
  CHECK(guard.off_px() < 0.3);
}

TEST_CASE("camera guard: a camera that moved") {
  // It is noticed from 2 mm on, and the calibration that follows brings places of the arena to where they are now,
  // within half a pixel.
  struct Row {
    double x_px, y_px, turn_deg;
  };
  for (const Row& row : {Row{2, 0, 0}, Row{-3, 4, 0}, Row{0, 0, 1}, Row{25, -14, 3}}) {
    CAPTURE(row.x_px);
    CAPTURE(row.turn_deg);
    const Calibration calibration = above();
    CameraGuard guard;
    guard.learn(find_landmarks(arena(), {}, calibration), calibration);
    std::optional<Calibration> now;
    std::uint64_t noise = 2;
    for (int k = 0; k < 25 && !now; ++k) {
      CHECK(guard.look(arena(row.x_px, row.y_px, row.turn_deg, 1, ++noise), calibration) != Verdict::in_place);
      now = guard.realigned();
    }
    REQUIRE(now);
    CHECK(guard.look(arena(row.x_px, row.y_px, row.turn_deg, 1, ++noise), *now) == Verdict::in_place);
    cv::Mat warp = cv::getRotationMatrix2D({319.5F, 239.5F}, row.turn_deg, 1);
    warp.at<double>(0, 2) += row.x_px, warp.at<double>(1, 2) += row.y_px;
    for (const cv::Point2d& place : {cv::Point2d(100, 100), cv::Point2d(500, 90), cv::Point2d(320, 240),
                                     cv::Point2d(120, 400), cv::Point2d(520, 380)}) {
      const auto on_arena = calibration.to_arena({place.x, place.y}, 0);
      REQUIRE(on_arena);
      const auto seen = now->to_pixel(*on_arena, 0);
      REQUIRE(seen);
      const double x = warp.at<double>(0, 0) * place.x + warp.at<double>(0, 1) * place.y + warp.at<double>(0, 2);
      const double y = warp.at<double>(1, 0) * place.x + warp.at<double>(1, 1) * place.y + warp.at<double>(1, 2);
      CHECK(std::hypot(seen->x - x, seen->y - y) < 0.5);
    }
  }
}

TEST_CASE("camera guard: what it cannot know") {
  // Darkness and another arena are no move, and nothing follows them; on an arena without marks everything is in place.
  const Calibration calibration = above();
  CameraGuard guard;
  guard.learn(find_landmarks(arena(), {}, calibration), calibration);
  cv::Mat other = arena(0, 0, 0, 1, 3);
  cv::flip(other, other, -1);
  for (int k = 0; k < 40; ++k) {
    CHECK(guard.look(arena(0, 0, 0, 0, static_cast<std::uint64_t>(k)), calibration) == Verdict::unrecognised);
    CHECK_FALSE(guard.realigned());
  }
  for (int k = 0; k < 40; ++k) {
    CHECK(guard.look(other, calibration) == Verdict::unrecognised);
    CHECK_FALSE(guard.realigned());
  }
  CHECK(guard.look(arena(), calibration) == Verdict::in_place);

  CameraGuard blank;
  blank.learn(find_landmarks(cv::Mat(480, 640, CV_8UC3, cv::Scalar(150, 150, 150)), {}, calibration), calibration);
  CHECK(blank.marks() == 0);
  CHECK(blank.look(arena(5, 5), calibration) == Verdict::in_place);
}
