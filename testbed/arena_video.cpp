#include "testbed/arena_video.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "arkmesh/shared_view_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/arenas/projection.hpp"
#include "hal/overlay/drawing_message.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "testbed/straight_pictures.hpp"
#include "tracker/annotate.hpp"
#include "tracker/overlay_painter.hpp"

namespace arkmesh::testbed {

ArenaVideo::ArenaVideo(const KilobotSettings& settings, hal::Bus& bus, std::filesystem::path directory)
    : lab_(settings.arena.info.name),
      frame_period_(settings.arena.info.frame_period),
      directory_(std::move(directory)) {
  subscriptions_.push_back(bus.subscribe(
      hal::channel::overlay,
      [this](std::string_view, std::span<const std::byte> bytes) { hal::read_overlay(bytes, overlay_, refused_); }));
  subscriptions_.push_back(bus.subscribe(
      hal::channel::shared, [this](std::string_view, std::span<const std::byte> bytes) { hear_shared(bytes); }));
}

// Robots of other labs as they would stand here.
void ArenaVideo::hear_shared(std::span<const std::byte> bytes) {
  shared_view_t view{};
  if (!hal::decode(bytes, view)) return;
  const hal::Projection projection{view.shift_x_m, view.shift_y_m, view.turn_rad, view.scale};
  ghosts_.clear();
  for (const lab_view_t& lab : view.labs) {
    if (lab.lab == lab_) continue;
    for (const shared_robot_t& robot : lab.robots) {
      ghosts_.push_back({.pose = projection.to_arena({robot.x_um * 1e-6, robot.y_um * 1e-6, robot.heading_urad * 1e-6}),
                         .led = hal::led_of(robot.led)});
    }
  }
}

void ArenaVideo::look(const testbed::Look& look) {
  for (const auto& [name, total] : refused_.all()) look.counters.set(name, total);
  for (std::size_t k = 0; k < look.pictures.size(); ++k)
    if (!look.pictures[k].empty()) store(k, draw(look.pictures[k], k, look.tracker));
}

cv::Mat ArenaVideo::draw(const cv::Mat& picture, std::size_t camera, const tracker::ArenaTracker& tracker) const {
  cv::Mat drawn = picture.clone();
  if (const tracker::Calibration* seen_by = tracker.calibration(camera)) {
    tracker::draw_border(drawn, *seen_by);
    tracker::draw_overlay(drawn, *seen_by, overlay_);
    tracker::draw_ghosts(drawn, *seen_by, ghosts_, hal::kilobot::body_radius_m / 2);
    tracker::draw_tracks(drawn, *seen_by, tracker.tracks(), kilobot_body());
  }
  return drawn;
}

void ArenaVideo::store(std::size_t camera, const cv::Mat& drawn) {
  Video& video = videos_[camera];
  if (video.failed) return;
  if (!video.writer.isOpened()) {
    const auto file = (directory_ / fmt::format("arena-camera{}.mp4", camera)).string();
    const double per_s = 1e6 / static_cast<double>(frame_period_.count());
    try {
      video.writer.open(file, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), per_s, drawn.size());
    } catch (const cv::Exception&) {
      // Said below.
    }
    if (!video.writer.isOpened()) {
      video.failed = true;
      spdlog::warn("{} cannot be written; the run continues without the video", file);
      return;
    }
  }
  video.writer.write(drawn);
}

Observer make_viewers(const KilobotSettings& settings, const hal::ArenaRequest& request) {
  const auto video = request.bus && settings.keep_video
                         ? std::make_shared<ArenaVideo>(settings, *request.bus, request.directory)
                         : nullptr;
  const auto pages = request.pictures ? std::make_shared<StraightPictures>(*request.pictures) : nullptr;
  return [video, pages](const Look& look) {
    if (video) video->look(look);
    if (pages) pages->look(look);
  };
}

}  // namespace arkmesh::testbed
