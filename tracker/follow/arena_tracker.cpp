#include "tracker/follow/arena_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arkmesh::tracker {
namespace {

constexpr int eager_search_every = 3;  // while robots are missing
constexpr double widest_reach =
    2.5;  // windows are at most so many radii wide; what is farther off is found by searching

// The robots' diameter in a camera's pictures over the whole arena: mean, and how far from it the extremes are.
DetectorSettings detection_for(const Calibration& camera, const ArenaTrackerSettings& settings) {
  DetectorSettings detection = settings.detection;
  double least = std::numeric_limits<double>::infinity(), most = 0;
  constexpr int steps = 8;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j) {
      const Point at{(i - steps / 2) * camera.data().arena_width_m / steps,
                     (j - steps / 2) * camera.data().arena_height_m / steps};
      const auto pixel = camera.to_pixel(at, settings.body.board_m);
      if (!pixel || camera.inside_px(*pixel) < 0) continue;
      const auto scale = camera.scale(at, settings.body.board_m);
      if (!scale) continue;
      least = std::min(least, scale->smallest);
      most = std::max(most, scale->largest);
    }
  if (!(most > 0)) return detection;
  const double middle = (least + most) / 2;
  detection.diameter_px = middle * settings.body.diameter_m;
  detection.diameter_tolerance =
      std::min(0.6, std::max(detection.diameter_tolerance, (most - least) / (2 * middle) + 0.1));
  return detection;
}

}  // namespace

ArenaTracker::ArenaTracker(std::vector<Calibration> cameras, const ArenaTrackerSettings& settings)
    : settings_(settings), associator_(settings.following) {
  for (Calibration& camera : cameras) {
    views_.emplace_back();
    realign(views_.size() - 1, std::move(camera));
  }
}

ArenaTracker::ArenaTracker(const ArenaTrackerSettings& settings)
    : settings_(settings), associator_(settings.following) {
  views_.emplace_back();
  views_.back().detector = std::make_unique<Detector>(settings.detection);
}

void ArenaTracker::realign(std::size_t camera, Calibration calibration) {
  View& view = views_[camera];
  view.plane = RectifiedView::of(calibration, settings_.body.board_m);
  view.detector =
      std::make_unique<Detector>(detection_for(view.plane ? view.plane->calibration() : calibration, settings_));
  view.calibration = std::move(calibration);
}

void ArenaTracker::detect(View& view, const cv::Mat& as_taken, std::span<const Prospect> prospects,
                          bool somebody_missing) {
  view.detections.clear();
  const cv::Mat& picture = view.plane ? view.plane->turn(as_taken) : as_taken;
  const bool search =
      !view.calibration || ++view.since_search >= (somebody_missing ? eager_search_every : settings_.search_every);
  if (search) {
    // Cameras take turns in later searches.
    const bool first = view.since_search > 1'000'000;
    view.since_search = first ? static_cast<int>((&view - views_.data()) * settings_.search_every /
                                                 static_cast<std::ptrdiff_t>(views_.size()))
                              : 0;
    view.detections = view.detector->search(picture);
  }
  if (!view.calibration) {
    const auto diameter_px = view.detector->diameter_px();
    if (view.detections.empty() || !diameter_px) return;
    view.calibration = Calibration::overhead(picture.cols, picture.rows, settings_.body.diameter_m / *diameter_px);
  }
  const Calibration& calibration = view.plane ? view.plane->calibration() : *view.calibration;
  // Where robots should be, more is seen than in a search of everything.
  std::vector<Expected> where;
  for (const Prospect& prospect : prospects) {
    const auto pixel = calibration.to_pixel({prospect.x_m, prospect.y_m}, settings_.body.board_m);
    if (!pixel) continue;
    const auto scale = calibration.scale({prospect.x_m, prospect.y_m}, settings_.body.board_m);
    if (!scale) continue;
    const double r_px = (scale->largest + scale->smallest) / 4 * settings_.body.diameter_m;
    if (calibration.inside_px(*pixel) < -0.5 * r_px) continue;
    where.push_back({pixel->x, pixel->y, r_px, std::min(prospect.reach_m * scale->largest, widest_reach * r_px)});
  }
  const std::size_t searched = view.detections.size();
  for (const auto& followed : view.detector->follow(picture, where)) {
    if (!followed) continue;
    const auto same = [&](const Detection& other) {
      return std::hypot(other.x_px - followed->x_px, other.y_px - followed->y_px) < 0.6 * (followed->r_px + other.r_px);
    };
    const auto end = view.detections.begin() + static_cast<std::ptrdiff_t>(searched);
    if (std::none_of(view.detections.begin(), end, same)) view.detections.push_back(*followed);
  }
  if (view.plane) view.detections = view.plane->in_camera(view.detections);
}

// A robot's centre cannot be beyond a wall by more than a radius, however wrong a calibration may be.
std::vector<FusedObservation> ArenaTracker::inside_arena(const Calibration& camera,
                                                         std::span<const Detection> detections) {
  std::vector<FusedObservation> seen = on_arena(camera, detections, settings_.body);
  const double east_m = (camera.data().arena_width_m + settings_.body.diameter_m) / 2,
               north_m = (camera.data().arena_height_m + settings_.body.diameter_m) / 2;
  const std::size_t outside = std::erase_if(
      seen, [&](const FusedObservation& one) { return std::abs(one.x_m) > east_m || std::abs(one.y_m) > north_m; });
  if (outside > 0) own_counters_.add("seen.outside", outside);
  return seen;
}

const std::vector<Track>& ArenaTracker::look(hal::LabTime now, std::span<const cv::Mat> pictures) {
  const std::vector<Prospect> prospects = associator_.prospects(now);
  const std::vector<Track>& before = associator_.tracks();
  const bool somebody_missing =
      before.size() < settings_.expected_robots || before.empty() ||
      std::any_of(before.begin(), before.end(), [](const Track& track) { return track.age.count() > 0; });
  std::vector<std::vector<FusedObservation>> seen(views_.size());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    View& view = views_[i];
    view.detections.clear();
    if (i >= pictures.size() || pictures[i].empty()) continue;
    const cv::Mat& picture = pictures[i];
    if (view.calibration && (picture.cols != view.calibration->data().lens.width_px ||
                             picture.rows != view.calibration->data().lens.height_px)) {
      own_counters_.add("camera.refused.size");
      continue;
    }
    detect(view, picture, prospects, somebody_missing);
    if (view.calibration) seen[i] = inside_arena(*view.calibration, view.detections);
  }
  return associator_.update(now, fuse(seen, settings_.body));
}

const hal::Counters& ArenaTracker::counters() const {
  counters_ = own_counters_;
  counters_.merge(associator_.counters());
  return counters_;
}

}  // namespace arkmesh::tracker
