#include "testbed/track_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hal/config/without_secrets.hpp"
#include "hal/counted.hpp"
#include "testbed/track_outputs.hpp"
#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/live_camera.hpp"
#include "tracker/camera/source.hpp"
#include "tracker/follow/arena_tracker.hpp"

namespace arkmesh::testbed {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using TimePoint = Clock::time_point;

constexpr std::chrono::milliseconds first_picture_within = 10s;
constexpr std::chrono::milliseconds look_every = 3ms;
constexpr double live_pictures_per_s = 15;  // of a camera's video

// Says that a camera fails, each fault at least once, and that it is back; a camera that comes and goes all the time is
// not a line each time.
class OutageReport {
 public:
  explicit OutageReport(hal::Progress& progress) : progress_(progress) {}
  void watch(const std::string& error, TimePoint now) {
    if (!error.empty()) last_error_ = now;
    const bool is_new = !error.empty() && known_.size() < most_known && known_.insert(error).second;
    if (error.empty() ? said_.empty() || now - last_error_ < 2s
                      : error == said_ || (!said_.empty() && now - said_at_ < 10s && !is_new))
      return;
    said_ = error;
    said_at_ = now;
    progress_.done();
    fmt::print(stderr, "arkmesh: {}\n", error.empty() ? "pictures arrive again" : error);
  }

 private:
  static constexpr std::size_t most_known = 20;

  hal::Progress& progress_;
  std::string said_;
  std::set<std::string> known_;
  TimePoint said_at_{}, last_error_{};
};

std::optional<tracker::CameraData> calibration_of(const StreamOptions& options) {
  if (options.calibration.empty()) return {};
  return tracker::read_calibration(options.calibration, options.camera).data;
}

tracker::ArenaTracker make_tracker(const StreamOptions& options,
                                   const std::optional<tracker::CameraData>& calibration) {
  tracker::ArenaTrackerSettings settings = kilobot_tracking();
  settings.following.led_offset_rad = options.led_offset_deg * std::numbers::pi / 180;
  if (options.diameter_px > 0) settings.detection.diameter_px = options.diameter_px;
  if (!calibration) return tracker::ArenaTracker(settings);
  settings.following.half_width_m = calibration->arena_width_m / 2;
  settings.following.half_height_m = calibration->arena_height_m / 2;
  return tracker::ArenaTracker({tracker::Calibration(*calibration)}, settings);
}

void refuse_other_size(const StreamOptions& options, const std::optional<tracker::CameraData>& calibration,
                       const cv::Mat& picture) {
  if (!calibration || (picture.cols == calibration->lens.width_px && picture.rows == calibration->lens.height_px))
    return;
  throw std::runtime_error(
      fmt::format("{} gives pictures of {} x {} pixels, and the calibration {} is for {} x {}; calibrate the "
                  "camera at this resolution",
                  options.source, picture.cols, picture.rows, options.calibration, calibration->lens.width_px,
                  calibration->lens.height_px));
}

// Pictures of a recording that are left out, said one by one until they are many.
class LeftOut {
 public:
  explicit LeftOut(hal::Progress& progress) : progress_(progress) {}
  void say(const std::string& what) {
    if (++all_ > said_singly) return;
    progress_.done();
    fmt::print(stderr, "arkmesh: {}; left out\n", what);
  }
  void sum_up() const {
    if (all_ > said_singly) fmt::print(stderr, "arkmesh: {} in total were skipped\n", hal::counted(all_, "picture"));
  }
  bool any() const { return all_ > 0; }

 private:
  static constexpr std::size_t said_singly = 5;
  hal::Progress& progress_;
  std::size_t all_ = 0;
};

// False when a picture could not be read or used, or some are missing.
bool track_recording(const StreamOptions& options, hal::StopRequest& stop, hal::Progress& progress) {
  const auto calibration = calibration_of(options);
  const auto recording = tracker::open_recording(options.source);
  if (recording->rate_is_guess())
    fmt::print(stderr, "arkmesh: {} has no time stamps; times assume {:g} pictures a second\n", options.source,
               recording->pictures_per_s());
  tracker::ArenaTracker tracker = make_tracker(options, calibration);
  TrackOutputs outputs(options, recording->pictures_per_s(), stop);
  const auto all = recording->pictures();
  const TimePoint begun = Clock::now();
  LeftOut left_out(progress);
  cv::Size size;
  while (!stop.stopped()) {
    const auto picture = recording->next();
    if (!picture || (options.seconds > 0 && picture->stamp.count() > options.seconds * 1e6)) break;
    if (picture->bgr.empty()) {
      left_out.say(fmt::format("{} {}", picture->name, tracker::no_picture));
      continue;
    }
    if (size.empty()) refuse_other_size(options, calibration, picture->bgr);
    if (size.empty()) size = picture->bgr.size();
    if (picture->bgr.size() != size) {
      left_out.say(fmt::format("{} is {} x {} pixels, those before {} x {}", picture->name, picture->bgr.cols,
                               picture->bgr.rows, size.width, size.height));
      continue;
    }
    tracker.look(picture->stamp, std::span(&picture->bgr, 1));
    outputs.add(*picture, tracker);
    // Somebody who watches sees it at life speed.
    outputs.serve_until(outputs.serving() ? begun + picture->stamp : begun);
    if (all && picture->number % 10 == 9) progress.show(picture->number + 1, *all, 1 / recording->pictures_per_s());
  }
  progress.done();
  left_out.sum_up();
  const std::string error = recording->error();
  if (outputs.pictures() == 0)
    throw std::runtime_error(error.empty() ? fmt::format("{} holds no picture that can be read", options.source)
                                           : error);
  if (!error.empty()) fmt::print(stderr, "arkmesh: {}\n", error);
  outputs.finish(tracker);
  return !left_out.any() && error.empty();
}

void track_camera(const StreamOptions& options, hal::StopRequest& stop, hal::Progress& progress) {
  const auto calibration = calibration_of(options);
  const tracker::Lens lens = calibration ? calibration->lens : tracker::Lens{};
  const auto camera = tracker::open_camera({options.source, lens.width_px, lens.height_px});
  tracker::ArenaTracker tracker = make_tracker(options, calibration);
  TrackOutputs outputs(options, live_pictures_per_s, stop);
  OutageReport outages(progress);
  hal::LabTime last{0};
  const TimePoint begun = Clock::now();
  while (!stop.stopped()) {
    outputs.serve_until(Clock::now() + look_every);
    const TimePoint now = Clock::now();
    const auto since = std::chrono::duration_cast<hal::LabTime>(now - begun);
    if (options.seconds > 0 && since.count() > options.seconds * 1e6) break;
    const cv::Mat bgr = camera->newest();
    const hal::LabTime taken = since - camera->arrival().age;
    if (outputs.pictures() > 0) outages.watch(camera->error(), now);
    if (bgr.empty()) {
      if (outputs.pictures() > 0) continue;
      if (since > first_picture_within) throw std::runtime_error(camera->error());
      progress.show(fmt::format("waiting for the first picture of {}", hal::without_secrets(options.source)));
      continue;
    }
    refuse_other_size(options, calibration, bgr);
    last = std::max(last, taken);
    const tracker::Picture picture{
        .bgr = bgr, .stamp = last, .number = static_cast<std::uint32_t>(outputs.pictures()), .name = {}};
    tracker.look(picture.stamp, std::span(&picture.bgr, 1));
    outputs.add(picture, tracker);
    const double since_s = static_cast<double>(since.count()) * 1e-6;
    progress.show(fmt::format("{:.0f} s, {}, {}; Ctrl-C ends it", since_s, hal::counted(outputs.robots(), "robot"),
                              hal::counted(outputs.pictures(), "picture")));
  }
  progress.done();
  if (outputs.pictures() == 0) throw std::runtime_error(camera->error());
  outputs.finish(tracker);
}

}  // namespace

bool track_stream(const StreamOptions& options, hal::StopRequest& stop, hal::Progress& progress) {
  tracker::quieten_libraries();
  if (tracker::source_kind(options.source) == tracker::SourceKind::recording)
    return track_recording(options, stop, progress);
  track_camera(options, stop, progress);
  return true;
}

}  // namespace arkmesh::testbed
