#include "tracker/follow/marker_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace arkmesh::tracker {
namespace {

constexpr double size_tolerance = 0.25;         // of a marker's sides on the arena
constexpr double window_margin_m = 0.01;        // around where a marker should be, beside its own size
constexpr hal::LabTime follows_for{1'000'000};  // unseen for longer: found by the search of parts
constexpr double searched_px = 400'000;         // searched in one look, so that it is quick
constexpr double noise_heading_rad = 0.02;

double in_half_turns(double angle_rad) {
  const double out = std::remainder(angle_rad, 2 * std::numbers::pi);
  return out > -std::numbers::pi ? out : std::numbers::pi;
}

}  // namespace

MarkerTracker::MarkerTracker(std::vector<Calibration> cameras, MarkerSettings settings)
    : settings_(std::move(settings)), finder_(settings_.family), missing_(settings_.robots) {
  for (Calibration& calibration : cameras) views_.push_back({std::move(calibration)});
}

std::vector<hal::Observation> MarkerTracker::look(hal::LabTime now, std::span<const cv::Mat> pictures) {
  struct Sum {
    double x_m = 0, y_m = 0, cos = 0, sin = 0;
    int cameras = 0;
  };
  std::map<hal::RobotId, Sum> sums;
  bool any = false;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (pictures[i].empty()) continue;
    const Lens& lens = views_[i].calibration.data().lens;
    if (pictures[i].cols != lens.width_px || pictures[i].rows != lens.height_px) {
      counters_.add("camera.refused.size");
      continue;
    }
    any = true;
    for (const Marker& marker : find(views_[i], pictures[i], now, !missing_.empty())) {
      const auto robot = static_cast<hal::RobotId>(marker.number);
      if (!std::ranges::binary_search(settings_.robots, robot)) {
        counters_.add("marker.refused.unknown");
        continue;
      }
      const auto pose = pose_of(views_[i], marker);
      if (!pose) {
        counters_.add("marker.refused.size");
        continue;
      }
      Sum& sum = sums[robot];
      sum.x_m += pose->x_m;
      sum.y_m += pose->y_m;
      sum.cos += std::cos(pose->heading_rad);
      sum.sin += std::sin(pose->heading_rad);
      ++sum.cameras;
    }
  }
  if (!any) return {};
  std::vector<hal::Observation> out;
  missing_.clear();
  for (const hal::RobotId robot : settings_.robots) {
    const auto found = sums.find(robot);
    if (found == sums.end()) {
      missing_.push_back(robot);
      continue;
    }
    const Sum& sum = found->second;
    const hal::Pose pose{sum.x_m / sum.cameras, sum.y_m / sum.cameras, in_half_turns(std::atan2(sum.sin, sum.cos))};
    const auto [before, fresh] = seen_.try_emplace(robot);
    Seen& seen = before->second;
    const double passed_s = std::chrono::duration<double>(now - seen.at).count();
    const bool follows = !fresh && now - seen.at <= follows_for && passed_s > 0;
    seen = {now, pose, follows ? (pose.x_m - seen.pose.x_m) / passed_s : 0,
            follows ? (pose.y_m - seen.pose.y_m) / passed_s : 0};
    out.push_back({.robot = robot,
                   .pose = pose,
                   .led = hal::Led::unknown,
                   .heading_noise_rad = static_cast<float>(noise_heading_rad)});
  }
  return out;
}

std::vector<Marker> MarkerTracker::find(View& view, const cv::Mat& picture, hal::LabTime now, bool anybody_missing) {
  std::vector<Marker> out;
  std::vector<int> twice;
  const auto look_at = [&](cv::Rect part) {
    for (const Marker& marker : finder_.find(picture, part, &twice)) {
      const auto same = std::ranges::find(out, marker.number, &Marker::number);
      if (same == out.end())
        out.push_back(marker);
      else if (std::hypot(same->middle_px().x - marker.middle_px().x, same->middle_px().y - marker.middle_px().y) >
               same->side_px() / 2)
        twice.push_back(marker.number);
    }
  };
  // windows that overlap become one: what stands between two of them is searched once
  std::vector<cv::Rect> windows;
  for (const auto& [robot, seen] : seen_) {
    auto around = window(view, seen, now);
    if (!around) continue;
    for (auto other = windows.begin(); other != windows.end();)
      if ((*other & *around).area() > around->area() / 4) {
        *around |= *other;
        windows.erase(other);
        other = windows.begin();
      } else {
        ++other;
      }
    windows.push_back(*around);
  }
  for (const cv::Rect& around : windows) look_at(around);
  if (anybody_missing) {
    const auto scale = view.calibration.scale({0, 0}, settings_.height_m);
    const int overlap_px = static_cast<int>(scale ? 2 * scale->largest * settings_.side_m : picture.rows / 4.0);
    const int parts = static_cast<int>(std::ceil(static_cast<double>(picture.total()) / searched_px));
    const int rows = picture.rows / parts + 1;
    view.next_part = (view.next_part + 1) % parts;
    look_at({0, view.next_part * rows - overlap_px / 2, picture.cols, rows + overlap_px});
  }
  counters_.add("marker.refused.twice", twice.size());
  std::erase_if(out, [&](const Marker& marker) { return std::ranges::count(twice, marker.number) > 0; });
  return out;
}

// Where it should be seen, with what it may have turned and accelerated meanwhile.
std::optional<cv::Rect> MarkerTracker::window(const View& view, const Seen& seen, hal::LabTime now) const {
  const auto unseen = now - seen.at;
  if (unseen > follows_for) return {};
  const double passed_s = std::chrono::duration<double>(unseen).count();
  const Point there{seen.pose.x_m + passed_s * seen.vx_m_s, seen.pose.y_m + passed_s * seen.vy_m_s};
  const auto pixel = view.calibration.to_pixel(there, settings_.height_m);
  const auto scale = view.calibration.scale(there, settings_.height_m);
  if (!pixel || !scale || view.calibration.inside_px(*pixel) < 0) return {};
  const double reach_m =
      0.9 * settings_.side_m + window_margin_m + 2 * settings_.top_speed_m_s * std::min(passed_s, 0.3);
  const int reach_px = static_cast<int>(std::ceil(reach_m * scale->largest));
  return cv::Rect(static_cast<int>(pixel->x) - reach_px, static_cast<int>(pixel->y) - reach_px, 2 * reach_px,
                  2 * reach_px);
}

std::optional<hal::Pose> MarkerTracker::pose_of(const View& view, const Marker& marker) const {
  std::array<Point, 4> on_arena;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto there = view.calibration.to_arena(marker.corners_px[i], settings_.height_m);
    if (!there) return {};
    on_arena[i] = *there;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const Point &a = on_arena[i], &b = on_arena[(i + 1) % 4];
    if (std::abs(std::hypot(a.x - b.x, a.y - b.y) / settings_.side_m - 1) > size_tolerance) return {};
  }
  const auto& [a, b, c, d] = on_arena;
  return hal::Pose{(a.x + b.x + c.x + d.x) / 4, (a.y + b.y + c.y + d.y) / 4,
                   in_half_turns(std::atan2(a.y + b.y - c.y - d.y, a.x + b.x - c.x - d.x) + settings_.turned_rad)};
}

double MarkerTracker::largest_speed_m_s(const MarkerSettings& settings, double exposure_s) {
  return settings.side_m / MarkerFinder::squares(settings.family) / exposure_s;
}

}  // namespace arkmesh::tracker
