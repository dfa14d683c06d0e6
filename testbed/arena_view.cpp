#include "testbed/arena_view.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "arkmesh/shared_view_t.hpp"
#include "hal/drawing_message.hpp"
#include "hal/messages.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "hal/projection.hpp"
#include "testbed/straight_pictures.hpp"
#include "tracker/annotate.hpp"
#include "tracker/overlay_painter.hpp"

namespace arkmesh::testbed {
namespace {

constexpr int jpeg_quality = 80;
constexpr hal::LabTime outage_after{1'500'000};
constexpr std::chrono::milliseconds again_after{950}, look_for_it_every{250};

// What people want to know at a glance.
std::string caption(const std::vector<tracker::Track>& tracks, hal::LabTime now) {
  const auto count = [&](auto is) { return std::count_if(tracks.begin(), tracks.end(), is); };
  const auto seen = count([](const tracker::Track& track) { return track.age.count() == 0; });
  const auto named = count([](const tracker::Track& track) { return track.robot && !track.doubtful; });
  return fmt::format("{:.1f} s: {} robots in sight, {} known by name", static_cast<double>(now.count()) * 1e-6, seen,
                     named);
}

}  // namespace

ArenaView::ArenaView(const KilobotSettings& settings, hal::Bus& bus, hal::EventLoop& loop,
                     std::filesystem::path directory)
    : lab_(settings.arena.info.name),
      frame_period_(settings.arena.info.frame_period),
      directory_(std::move(directory)),
      keep_video_(settings.window.keep_video) {
  if (settings.window.open) {
    server_ = std::make_unique<hal::MjpegServer>(loop, "127.0.0.1", settings.window.port);
    for (std::size_t k = 0; k < settings.cameras.size(); ++k) server_->announce(stream(k));
    again_.emplace(loop, look_for_it_every, [this] { show_again(); });
    spdlog::info("the testbed is to be seen at http://127.0.0.1:{}/", server_->port());
  }
  subscriptions_.push_back(bus.subscribe(
      hal::channel::overlay,
      [this](std::string_view, std::span<const std::byte> bytes) { hal::read_overlay(bytes, overlay_, refused_); }));
  subscriptions_.push_back(bus.subscribe(
      hal::channel::shared, [this](std::string_view, std::span<const std::byte> bytes) { hear_shared(bytes); }));
}

// Robots of other labs as they would stand here.
void ArenaView::hear_shared(std::span<const std::byte> bytes) {
  shared_view_t view{};
  if (!hal::decode(bytes, view)) return;
  const hal::Projection projection{view.shift_x_m, view.shift_y_m, view.turn_rad, view.scale};
  ghosts_.clear();
  for (const lab_view_t& lab : view.labs) {
    if (lab.lab == lab_) continue;
    for (const shared_robot_t& robot : lab.robots) {
      ghosts_.push_back({.pose = projection.to_arena({robot.x_um * 1e-6, robot.y_um * 1e-6, robot.heading_urad * 1e-6}),
                         .led = static_cast<hal::Led>(robot.led & 7)});
    }
  }
}

void ArenaView::look(const testbed::Look& look) {
  if (server_)
    for (const auto& [name, total] : server_->counters().all()) look.counters.set(name, total);
  for (const auto& [name, total] : refused_.all()) look.counters.set(name, total);
  tracker_ = &look.tracker;
  for (std::size_t k = 0; k < look.pictures.size(); ++k) {
    const cv::Mat& picture = look.pictures[k];
    if (picture.empty()) {
      if (const auto last = last_.find(k); last != last_.end()) last->second.missing = look.now - last->second.at;
      continue;
    }
    Last& last = last_[k];
    last.picture = picture;
    last.at = look.now;
    last.missing = {};
    if (!watched(k) && !keep_video_) continue;
    cv::Mat drawn = draw(picture, k, look.tracker);
    if (keep_video_) store(k, drawn);
    if (watched(k)) show(k, drawn, caption(look.tracker.tracks(), look.now));
  }
}

cv::Mat ArenaView::draw(const cv::Mat& picture, std::size_t camera, const tracker::TableTracker& tracker) const {
  cv::Mat drawn = picture.clone();
  if (const tracker::Calibration* seen_by = tracker.calibration(camera)) {
    tracker::draw_border(drawn, *seen_by);
    tracker::draw_overlay(drawn, *seen_by, overlay_);
    tracker::draw_ghosts(drawn, *seen_by, ghosts_, hal::kilobot::body_radius_m / 2);
    tracker::draw_tracks(drawn, *seen_by, tracker.tracks(), kilobot_body());
  }
  return drawn;
}

// Nobody takes a picture that stands still for the testbed.
void ArenaView::show_again() {
  const auto now = std::chrono::steady_clock::now();
  for (const auto& [camera, last] : last_) {
    if (now - last.shown < again_after || !watched(camera)) continue;
    if (last.missing < outage_after) {
      show(camera, draw(last.picture, camera, *tracker_), caption(tracker_->tracks(), last.at));
      continue;
    }
    cv::Mat dark;
    last.picture.convertTo(dark, -1, 0.4);
    show(camera, dark, fmt::format("no new picture for {:.0f} s", static_cast<double>(last.missing.count()) * 1e-6));
  }
}

void ArenaView::show(std::size_t camera, cv::Mat drawn, const std::string& words) {
  tracker::draw_caption(drawn, words);
  std::vector<unsigned char> jpeg;
  if (cv::imencode(".jpg", drawn, jpeg, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality}))
    server_->show(stream(camera), std::as_bytes(std::span(jpeg)));
  last_[camera].shown = std::chrono::steady_clock::now();
}

void ArenaView::store(std::size_t camera, const cv::Mat& drawn) {
  Video& video = videos_[camera];
  if (video.failed) return;
  if (!video.writer.isOpened()) {
    const auto file = (directory_ / fmt::format("arena-{}.mp4", stream(camera))).string();
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

Observer make_window(const hal::Section& kilobot, const KilobotSettings& settings, const hal::ArenaRequest& request) {
  if (!request.bus) return {};
  try {
    const auto window = std::make_shared<ArenaView>(settings, *request.bus, *request.loop, request.directory);
    const auto pages = request.pictures ? std::make_shared<StraightPictures>(*request.pictures) : nullptr;
    return [window, pages](const Look& look) {
      window->look(look);
      if (pages) pages->look(look);
    };
  } catch (const std::runtime_error& wrong) {
    kilobot.refuse("window_port", wrong.what());
  }
}

}  // namespace arkmesh::testbed
