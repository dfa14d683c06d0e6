#include "tracker/follow/view_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace arkmesh::tracker {
namespace {

// By how much calibrations of cameras differ; of one camera it stays the same.
constexpr double camera_noise_m = 0.0003;

}  // namespace

std::vector<FusedObservation> on_arena(const Calibration& camera, std::span<const Detection> detections,
                                       const Body& body, const LookNoise& noise) {
  std::vector<FusedObservation> seen;
  seen.reserve(detections.size());
  for (const Detection& found : detections) {
    const Point pixel{found.x_px, found.y_px};
    const double inside_px = camera.inside_px(pixel);
    if (inside_px < 0.3 * found.r_px) continue;
    const auto place = camera.to_arena(pixel, body.board_m);
    if (!place) continue;
    const auto scale = camera.scale(*place, body.board_m);
    if (!scale || !(scale->smallest > 1)) continue;

    FusedObservation one{.x_m = place->x,
                         .y_m = place->y,
                         .confidence = found.confidence,
                         .led = found.led,
                         .led_confidence = found.led_confidence,
                         .primary = found.primary,
                         .primary_confidence = found.primary_confidence};
    // A robot that the picture's edge cuts is placed less well, and so is one seen from aside.
    const double cut = inside_px < found.r_px ? 3 : 1;
    one.sigma_m = cut * noise.centre_px / scale->smallest;
    if (found.led != hal::Led::off && std::isfinite(found.led_x_px) && std::isfinite(found.led_y_px)) {
      const double off_px = std::hypot(found.led_x_px - found.x_px, found.led_y_px - found.y_px);
      const auto led = camera.to_arena({found.led_x_px, found.led_y_px}, body.led_m);
      // Near the edge is where a robot's own LED is.
      if (led && off_px > 0.4 * found.r_px && off_px < 1.2 * found.r_px) {
        one.led_heading_rad = std::atan2(led->y - place->y, led->x - place->x);
        one.led_heading_sigma_rad = cut * std::atan2(noise.led_px, off_px);
      }
    }
    seen.push_back(one);
  }
  return seen;
}

std::vector<FusedObservation> fuse(std::span<const std::vector<FusedObservation>> views, const Body& body) {
  if (views.size() == 1) return views[0];
  struct Item {
    std::size_t view;
    const FusedObservation* seen;
    std::size_t group;
  };
  std::vector<Item> items;
  for (std::size_t view = 0; view < views.size(); ++view)
    for (const FusedObservation& seen : views[view]) items.push_back({view, &seen, 0});
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
    return std::tuple(a.seen->x_m, a.seen->y_m, a.view) < std::tuple(b.seen->x_m, b.seen->y_m, b.view);
  });

  // Pairs of different cameras that are nearer than two bodies can be, the nearest first.
  struct Pair {
    double apart_m;
    std::size_t a, b;
  };
  std::vector<Pair> pairs;
  const double nearest_bodies_m = 0.6 * body.diameter_m;
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].group = i;
    for (std::size_t j = i + 1; j < items.size() && items[j].seen->x_m - items[i].seen->x_m < nearest_bodies_m; ++j) {
      const double apart_m =
          std::hypot(items[j].seen->x_m - items[i].seen->x_m, items[j].seen->y_m - items[i].seen->y_m);
      if (items[i].view != items[j].view && apart_m < nearest_bodies_m) pairs.push_back({apart_m, i, j});
    }
  }
  const auto nearer = [](const Pair& p, const Pair& q) {
    return std::tuple(p.apart_m, p.a, p.b) < std::tuple(q.apart_m, q.a, q.b);
  };
  std::sort(pairs.begin(), pairs.end(), nearer);

  // A group has each camera at most once.
  std::vector<std::vector<std::size_t>> groups(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) groups[i] = {i};
  for (const Pair& pair : pairs) {
    const std::size_t into = items[pair.a].group, from = items[pair.b].group;
    if (into == from) continue;
    const bool meets_itself = std::any_of(groups[into].begin(), groups[into].end(), [&](std::size_t i) {
      return std::any_of(groups[from].begin(), groups[from].end(),
                         [&](std::size_t j) { return items[i].view == items[j].view; });
    });
    if (meets_itself) continue;
    for (const std::size_t j : groups[from]) {
      items[j].group = into;
      groups[into].push_back(j);
    }
    groups[from].clear();
  }

  std::vector<FusedObservation> fused;
  for (const auto& group : groups) {
    if (group.empty()) continue;
    FusedObservation one = *items[group.front()].seen;
    double weight = 0, x = 0, y = 0, led_weight = 0, led_x = 0, led_y = 0;
    float doubt = 1;
    for (const std::size_t i : group) {
      const FusedObservation& seen = *items[i].seen;
      const double w = 1 / (seen.sigma_m * seen.sigma_m + camera_noise_m * camera_noise_m);
      weight += w, x += w * seen.x_m, y += w * seen.y_m;
      doubt *= 1 - seen.confidence;
      if (seen.led_confidence > one.led_confidence) one.led = seen.led, one.led_confidence = seen.led_confidence;
      if (seen.primary_confidence > one.primary_confidence)
        one.primary = seen.primary, one.primary_confidence = seen.primary_confidence;
      if (!seen.led_heading_rad) continue;
      const double lw = 1 / (seen.led_heading_sigma_rad * seen.led_heading_sigma_rad);
      led_weight += lw, led_x += lw * std::cos(*seen.led_heading_rad), led_y += lw * std::sin(*seen.led_heading_rad);
    }
    one.x_m = x / weight;
    one.y_m = y / weight;
    one.sigma_m = 1 / std::sqrt(weight);
    one.confidence = 1 - doubt;
    one.led_heading_rad.reset();
    if (led_weight > 0 && one.led != hal::Led::off) {
      one.led_heading_rad = std::atan2(led_y, led_x);
      one.led_heading_sigma_rad = 1 / std::sqrt(led_weight);
    }
    fused.push_back(one);
  }
  return fused;
}

}  // namespace arkmesh::tracker
