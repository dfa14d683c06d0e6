#include "testbed/track_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <stdexcept>

#include "hal/arenas/messages.hpp"
#include "hal/bus/loss.hpp"
#include "hal/counted.hpp"
#include "hal/overlay/led_name.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "testbed/robots_on_picture.hpp"
#include "tracker/annotate.hpp"

namespace arkmesh::testbed {
namespace {

using TimePoint = std::chrono::steady_clock::time_point;

constexpr std::chrono::milliseconds stop_within{20};
constexpr double longest_still_s = 1;  // a camera that gave nothing for longer leaves a jump in the video

double seconds(hal::LabTime t) {
  return static_cast<double>(t.count()) * 1e-6;
}

std::optional<tracker::Point> pixel_of(const tracker::Track& track, const tracker::Calibration* camera) {
  return camera ? camera->to_pixel({track.in_arena.x_m, track.in_arena.y_m}, hal::kilobot::board_height_m)
                : std::nullopt;
}

void print_json(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks,
                const tracker::Calibration* camera) {
  const auto number = [](double value, double steps) { return std::round(value * steps) / steps; };
  nlohmann::json robots = nlohmann::json::array();
  for (const tracker::Track& track : tracks) {
    nlohmann::json robot = {
        {"track", track.number},
        {"x_m", number(track.in_arena.x_m, 1e6)},
        {"y_m", number(track.in_arena.y_m, 1e6)},
        {"heading_rad", track.heading_sigma_rad < 3 ? number(track.in_arena.heading_rad, 1e5) : std::nan("")},
        {"led", hal::name_of(track.led)},
        {"confidence", number(static_cast<double>(track.confidence), 1e3)},
        {"age_s", number(seconds(track.age), 1e3)},
        {"doubtful", track.doubtful}};
    if (const auto at = pixel_of(track, camera)) robot["x_px"] = number(at->x, 1e3), robot["y_px"] = number(at->y, 1e3);
    robots.push_back(std::move(robot));
  }
  const nlohmann::json line = {
      {"frame", picture.number}, {"time_s", seconds(picture.stamp)}, {"robots", std::move(robots)}};
  fmt::print("{}\n", line.dump());
  if (std::fflush(stdout) != 0) throw std::runtime_error(fmt::format("cannot print more: {}", std::strerror(errno)));
}

}  // namespace

TrackOutputs::TrackOutputs(const StreamOptions& options, double pictures_per_s, hal::StopRequest& stop)
    : options_(options), pictures_per_s_(pictures_per_s), stop_(stop) {
  if (!options.csv.empty()) {
    csv_.open(options.csv, std::ios::binary);
    csv_ << "frame,time_s,track,x_m,y_m,heading_rad,heading_sigma_rad,led,confidence,age_s,doubtful,x_px,y_px\n";
    if (!csv_.flush())
      throw std::runtime_error(
          fmt::format("{} cannot be written: give a name in a folder that exists and may be written", options.csv));
  }
  if (!options.publish.empty()) bus_.emplace(options.publish);
  if (options.serve_port >= 0) {
    server_.emplace(loop_, "127.0.0.1", static_cast<std::uint16_t>(options.serve_port));
    server_->announce("arena");
    fmt::print(stderr, "http://127.0.0.1:{}/arena shows the robots\n", server_->port());
  }
}

void TrackOutputs::add(const tracker::Picture& picture, const tracker::ArenaTracker& tracker) {
  const std::vector<tracker::Track>& tracks = tracker.tracks();
  const tracker::Calibration* camera = tracker.calibration(0);
  most_ = std::max(most_, tracks.size());
  robots_ = tracks.size();
  ++pictures_;
  if (options_.json) print_json(picture, tracks, camera);
  if (csv_.is_open()) write_rows(picture, tracks, camera);
  if (bus_) publish(picture, tracks);
  const bool watched = server_ && server_->watchers("arena") > 0;
  if (options_.video.empty() && options_.png.empty() && !watched) return;
  cv::Mat drawn = picture.bgr.clone();
  if (camera && !options_.calibration.empty()) tracker::draw_border(drawn, *camera);
  if (camera) tracker::draw_tracks(drawn, *camera, tracks, kilobot_body());
  if (!options_.video.empty()) write_video(drawn, picture.stamp);
  if (!options_.png.empty()) last_picture_ = watched ? drawn.clone() : drawn;
  if (watched) show(drawn, picture.stamp);
}

void TrackOutputs::serve_until(TimePoint then) {
  do time_.wait_until(std::min(then, time_.now() + stop_within));
  while (time_.now() < then && !stop_.stopped());
}

void TrackOutputs::finish(const tracker::ArenaTracker& tracker) {
  if (csv_.is_open()) {
    csv_.close();
    if (!csv_)
      throw std::runtime_error(fmt::format("{} could not be written to the end; is the disk full?", options_.csv));
  }
  if (video_.isOpened()) tracker::finish_video(video_, options_.video, video_pictures_);
  if (!options_.png.empty()) tracker::write_picture(options_.png, last_picture_);
  if (most_ == 0 && options_.calibration.empty())
    fmt::print(stderr, "arkmesh: {}\n", nothing_found(options_.diameter_px));
  if (options_.json) return;
  fmt::print("{}, {} at the end, at most {}\n", hal::counted(pictures_, "picture"), hal::counted(robots_, "robot"),
             most_);
  for (const auto& [name, total] : tracker.counters().all()) fmt::print("  {:<24} {}\n", name, total);
  if (const std::string words = hal::tracking_words(tracker.counters()); !words.empty()) fmt::print("{}\n", words);
}

void TrackOutputs::write_rows(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks,
                              const tracker::Calibration* camera) {
  for (const tracker::Track& track : tracks) {
    const auto at = pixel_of(track, camera);
    csv_ << fmt::format("{},{:.6f},{},{:.6f},{:.6f},{:.5f},{:.4f},{},{:.3f},{:.3f},{},{:.2f},{:.2f}\n", picture.number,
                        seconds(picture.stamp), track.number, track.in_arena.x_m, track.in_arena.y_m,
                        track.in_arena.heading_rad, track.heading_sigma_rad, hal::name_of(track.led), track.confidence,
                        seconds(track.age), track.doubtful ? 1 : 0, at ? at->x : std::nan(""),
                        at ? at->y : std::nan(""));
  }
}

// As a lab does, tracks' numbers in the place of ids.
void TrackOutputs::publish(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks) {
  hal::PoseFrame frame{.stamp = picture.stamp, .number = picture.number, .robots = {}};
  for (const tracker::Track& track : tracks)
    frame.robots.push_back({track.number, track.in_arena, track.led, track.confidence, track.age});
  for (const auto& message : hal::to_messages(frame)) bus_->publish(hal::channel::poses, message);
}

// At life speed: a camera slower than the video gives some pictures twice, one that is faster some not at all.
void TrackOutputs::write_video(const cv::Mat& drawn, hal::LabTime stamp) {
  if (!video_.isOpened()) {
    const bool jpegs = options_.video.ends_with(".avi");
    const int code = jpegs ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G') : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
    try {
      video_.open(options_.video, code, pictures_per_s_, drawn.size());
    } catch (const cv::Exception&) {
      // Said below.
    }
    if (!video_.isOpened())
      throw std::runtime_error(fmt::format(
          "{} cannot be written: give a name ending in .mp4 or .avi in a folder that exists", options_.video));
    in_video_ = std::llround(seconds(stamp) * pictures_per_s_);
  }
  const std::int64_t due = std::llround(seconds(stamp) * pictures_per_s_) + 1;
  in_video_ = std::max(in_video_, due - std::max<std::int64_t>(1, std::llround(longest_still_s * pictures_per_s_)));
  for (; in_video_ < due; ++in_video_, ++video_pictures_) video_.write(drawn);
}

void TrackOutputs::show(const cv::Mat& drawn, hal::LabTime stamp) {
  cv::Mat titled = drawn;
  tracker::draw_caption(titled, fmt::format("{:.1f} s: {}", seconds(stamp), hal::counted(robots_, "robot")));
  std::vector<unsigned char> jpeg;
  if (!cv::imencode(".jpg", titled, jpeg, {cv::IMWRITE_JPEG_QUALITY, 80})) return;
  server_->show("arena", std::as_bytes(std::span(jpeg)));
}

}  // namespace arkmesh::testbed
