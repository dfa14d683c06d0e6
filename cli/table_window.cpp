#include "cli/table_window.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "arkmesh/shared_view_t.hpp"
#include "hal/arena_config.hpp"
#include "hal/messages.hpp"
#include "scenarios/projection.hpp"
#include "tracker/annotate.hpp"

namespace arkmesh::cli {
namespace {

constexpr int jpeg_quality = 80;

}  // namespace

TableWindow::TableWindow(const hal::Section& kilobot, const std::string& lab, hal::LabTime frame_period, hal::Bus& bus, std::filesystem::path directory)
    : lab_(lab), frame_period_(frame_period), directory_(std::move(directory)), keep_video_(kilobot.flag("video", false)) {
  const bool open = kilobot.flag("window", true);
  const auto port = static_cast<std::uint16_t>(kilobot.integer("window_port", 0, 0, 65535));
  if (open) {
    try {
      server_ = std::make_unique<hal::MjpegServer>("127.0.0.1", port);
    } catch (const std::runtime_error& wrong) {
      kilobot.refuse("window_port", wrong.what());
    }
    spdlog::info("the table is to be seen at http://127.0.0.1:{}/", server_->port());
  }
  subscriptions_.push_back(bus.subscribe(hal::channel::marks, [this](std::string_view, std::span<const std::byte> bytes) {
    if (marks_t message; hal::decode(bytes, message)) marks_ = hal::from_message(message);
  }));
  subscriptions_.push_back(bus.subscribe(hal::channel::shared, [this](std::string_view, std::span<const std::byte> bytes) { hear_shared(bytes); }));
}

// Robots of other labs as they would stand here.
void TableWindow::hear_shared(std::span<const std::byte> bytes) {
  shared_view_t view;
  if (!hal::decode(bytes, view)) return;
  const scenarios::Projection projection{view.shift_x_m, view.shift_y_m, view.turn_rad, view.scale};
  ghosts_.clear();
  for (const lab_view_t& lab : view.labs) {
    if (lab.lab == lab_) continue;
    for (const shared_robot_t& robot : lab.robots) {
      const hal::Pose at = projection.to_arena({robot.x_um * 1e-6, robot.y_um * 1e-6, robot.heading_urad * 1e-6});
      ghosts_.push_back({.x_m = at.x_m, .y_m = at.y_m, .radius_m = hal::kilobot_radius_m / 2, .colour = static_cast<hal::Led>(robot.led & 7)});
    }
  }
}

void TableWindow::look(const tracker::Look& look) {
  if (server_) server_->serve();
  for (std::size_t k = 0; k < look.pictures.size(); ++k) {
    const cv::Mat& picture = look.pictures[k];
    const bool watched = server_ && server_->watchers(stream(k)) > 0;
    if (picture.empty() || !(watched || keep_video_)) continue;
    cv::Mat drawn = picture.clone();
    if (const tracker::Calibration* camera = look.tracker.calibration(k)) {
      tracker::draw_marks(drawn, *camera, marks_);
      tracker::draw_marks(drawn, *camera, ghosts_);
      tracker::draw_tracks(drawn, *camera, look.tracker.tracks());
    }
    if (keep_video_) store(k, drawn);
    std::vector<unsigned char> jpeg;
    if (watched && cv::imencode(".jpg", drawn, jpeg, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality})) server_->show(stream(k), std::as_bytes(std::span(jpeg)));
  }
  if (server_) server_->serve();
}

void TableWindow::store(std::size_t camera, const cv::Mat& drawn) {
  Video& video = videos_[camera];
  if (video.failed) return;
  if (!video.writer.isOpened()) {
    const auto file = (directory_ / fmt::format("table-{}.mp4", stream(camera))).string();
    const double per_s = 1e6 / static_cast<double>(frame_period_.count());
    try {
      video.writer.open(file, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), per_s, drawn.size());
    } catch (const cv::Exception&) {
      // Said below.
    }
    if (!video.writer.isOpened()) {
      video.failed = true;
      spdlog::warn("{} cannot be written; the run goes on without the video", file);
      return;
    }
  }
  video.writer.write(drawn);
}

}  // namespace arkmesh::cli
