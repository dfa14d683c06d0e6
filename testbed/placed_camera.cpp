#include "testbed/placed_camera.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace arkmesh::testbed {
namespace {

using Verdict = tracker::CameraGuard::Verdict;

// Pictures, ten a second. The guard needs twenty to correct a calibration.
constexpr int unrecognised_enough = 30, robots_enough = 10, moved_enough = 50;
constexpr double seen_well = 0.5;  // so many of a calibration's landmarks do for a whole run

double hangs_apart_m(const tracker::Calibration& a, const tracker::Calibration& b) {
  const auto &one = a.position_m(), &other = b.position_m();
  return std::hypot(one[0] - other[0], one[1] - other[1], one[2] - other[2]);
}

// How far off a place in the arena is at most that was read with `before` of a camera that is like `now`.
double most_off_m(const tracker::Calibration& before, const tracker::Calibration& now) {
  constexpr int steps = 8;
  double most = 0;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j) {
      const tracker::Point at{(static_cast<double>(i) / steps - 0.5) * now.data().arena_width_m,
                              (static_cast<double>(j) / steps - 0.5) * now.data().arena_height_m};
      const auto pixel = now.to_pixel(at, 0);
      if (!pixel || now.inside_px(*pixel) < 0) continue;
      if (const auto read = before.to_arena(*pixel, 0))
        most = std::max(most, std::hypot(read->x - at.x, read->y - at.y));
    }
  return most;
}

}  // namespace

PlacedCamera::PlacedCamera(std::size_t number, std::string source, std::string remedy,
                           std::span<const tracker::Landmark> landmarks, const tracker::ArenaTracker& tracker,
                           hal::Counters& counters)
    : number_(number), source_(std::move(source)), remedy_(std::move(remedy)) {
  if (landmarks.size() >= tracker::CameraGuard::fewest_marks) {
    guard_.learn(landmarks, *tracker.calibration(number));
    settled_ = false;
    return;
  }
  counters.add("camera.no_landmarks");
  spdlog::info(
      "the calibration of the camera {} has no landmarks of the arena, so a later move of the camera cannot be "
      "detected; calibrate it again: {}",
      source_, remedy_);
}

bool PlacedCamera::in_place(const cv::Mat& picture, tracker::ArenaTracker& tracker, hal::Counters& counters) {
  const tracker::Calibration* const calibration = tracker.calibration(number_);
  if (!guard_.has_learnt() || !calibration || picture.cols != calibration->data().lens.width_px ||
      picture.rows != calibration->data().lens.height_px)
    return true;
  const Verdict verdict = guard_.look(picture, *calibration);
  if (verdict == Verdict::in_place) {
    said_moved_ = false;
    error_.clear();
    if (std::exchange(amiss_, false)) spdlog::info("the camera {} shows the arena again", source_);
    if (!std::exchange(settled_, true)) renew_ = guard_.seen_part() < seen_well;
    return true;
  }
  auto now = guard_.realigned();
  if (!settled_ && !now && at_start(verdict, counters)) return true;
  counters.add(verdict == Verdict::moved ? "camera.refused.moved" : "camera.refused.unrecognised");
  if (!std::exchange(amiss_, true) && verdict == Verdict::unrecognised) {
    counters.add("camera.unrecognised");
    spdlog::warn("the camera {} does not show the arena: dark, covered, or turned away? Its pictures are not used",
                 source_);
  }
  if ((now || verdict == Verdict::moved) && !std::exchange(said_moved_, true)) {
    counters.add("camera.moved");
    spdlog::warn("the camera {} was moved{}: its pictures are not used until its new position is known", source_,
                 settled_ ? "" : " since it was calibrated");
  }
  if (now) {
    spdlog::warn(
        "the camera {} hangs {:.1f} mm from {}, which puts robots up to {:.1f} mm off, and its calibration was "
        "corrected for this run; calibrate it again when possible: {}",
        source_, 1000 * hangs_apart_m(*calibration, *now), settled_ ? "its former position" : "where it was calibrated",
        1000 * most_off_m(*calibration, *now), remedy_);
    tracker.realign(number_, std::move(*now));
    counters.add("camera.realigned");
    settled_ = true;
    error_.clear();
  }
  return false;
}

// Before the calibration's landmarks have been seen where they belong. True: the picture is used without them.
bool PlacedCamera::at_start(Verdict verdict, hal::Counters& counters) {
  if (verdict == Verdict::unrecognised) {
    robots_ = unrecognised_++ < unrecognised_enough ? 0 : robots_;
  } else {
    unrecognised_ = 0;
  }
  if ((moved_ > 0 || verdict == Verdict::moved) && ++moved_ == moved_enough) {
    counters.add("camera.moved_at_start");
    error_ = fmt::format(
        "the camera {} was moved since it was calibrated, and the visible landmarks do not determine its new position; "
        "calibrate it again: {}",
        source_, remedy_);
    spdlog::warn("{}", error_);
  }
  return unrecognised_ > unrecognised_enough;
}

// The first picture in which robots are is the one that a calibration without landmarks is for.
void PlacedCamera::learn(const cv::Mat& picture, const tracker::ArenaTracker& tracker, hal::Counters& counters) {
  const tracker::Calibration* const calibration = tracker.calibration(number_);
  if (picture.empty() || !calibration || (settled_ && guard_.has_learnt() && !renew_)) return;
  const std::vector<tracker::Detection>& robots = tracker.detections(number_);
  if (settled_ ? robots.empty() : (robots_ = robots.empty() ? 0 : robots_ + 1) < robots_enough) return;
  guard_.learn(tracker::find_landmarks(picture, robots, *calibration), *calibration);
  renew_ = amiss_ = said_moved_ = false;
  error_.clear();
  spdlog::debug("the camera {} is monitored by {} landmarks in the arena", source_, guard_.marks());
  if (std::exchange(settled_, true)) return;
  counters.add("camera.unrecognised_at_start");
  spdlog::warn(
      "the camera {} does not show the landmarks of its calibration: the arena has changed since, or the camera was "
      "moved far. Its poses are used unchanged; check that the drawn border lies on the real one, and calibrate "
      "it "
      "again: {}",
      source_, remedy_);
}

}  // namespace arkmesh::testbed
