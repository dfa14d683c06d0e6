#include "cli/track_stream.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "cli/progress.hpp"
#include "cli/swarm_report.hpp"
#include "hal/bus.hpp"
#include "hal/messages.hpp"
#include "hal/mjpeg_server.hpp"
#include "tracker/annotate.hpp"
#include "tracker/calibration_file.hpp"
#include "tracker/live_camera.hpp"
#include "tracker/source.hpp"
#include "tracker/table_tracker.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;
using Moment = std::chrono::steady_clock::time_point;

constexpr std::chrono::milliseconds first_picture_within = 10s;
constexpr std::chrono::milliseconds serve_every = 3ms;

volatile std::sig_atomic_t interrupted = 0;

// Everything that is made of the tracks of a picture.
class Outputs {
 public:
  Outputs(const StreamOptions& options, double pictures_per_s) : options_(options), pictures_per_s_(pictures_per_s) {
    if (!options.csv.empty()) {
      csv_.open(options.csv, std::ios::binary);
      csv_ << "frame,time_s,track,x_m,y_m,heading_rad,heading_sigma_rad,led,confidence,age_s,doubtful,x_px,y_px\n";
      if (!csv_) throw std::runtime_error(fmt::format("{} cannot be written", options.csv));
    }
    if (!options.publish.empty()) bus_.emplace(options.publish);
    if (options.serve_port >= 0) {
      server_.emplace("127.0.0.1", static_cast<std::uint16_t>(options.serve_port));
      server_->announce("table");
      fmt::print(stderr, "http://127.0.0.1:{}/table shows the robots\n", server_->port());
    }
  }

  void add(const tracker::Picture& picture, const tracker::TableTracker& table) {
    const std::vector<tracker::Track>& tracks = table.tracks();
    const tracker::Calibration* camera = table.calibration(0);
    most_ = std::max(most_, tracks.size());
    last_ = tracks.size();
    ++frames_;
    if (options_.json) print_json(picture, tracks, camera);
    if (csv_.is_open()) write_rows(picture, tracks, camera);
    if (bus_) publish(picture, tracks);
    const bool watched = server_ && server_->watchers("table") > 0;
    if (options_.video.empty() && options_.png.empty() && !watched) return;
    cv::Mat drawn = picture.bgr.clone();
    if (camera) tracker::draw_tracks(drawn, *camera, tracks);
    if (!options_.video.empty()) write_video(drawn);
    if (watched) show(drawn);
    if (!options_.png.empty()) last_picture_ = drawn;
  }

  // Lets people who watch have their pictures; returns at `then`, or soon when there is nobody to serve.
  void serve_until(Moment then) {
    do {
      if (server_) server_->serve();
      const Moment now = std::chrono::steady_clock::now();
      if (now >= then || interrupted) return;
      std::this_thread::sleep_until(std::min(then, now + serve_every));
    } while (true);
  }
  bool serving() const { return server_.has_value(); }

  void finish(const tracker::TableTracker& table) {
    if (csv_.is_open()) {
      csv_.close();
      if (!csv_) throw std::runtime_error(fmt::format("{} could not be written to the end; is the disk full?", options_.csv));
    }
    if (!options_.png.empty()) {
      bool written = false;
      try {
        written = !last_picture_.empty() && cv::imwrite(options_.png, last_picture_);
      } catch (const cv::Exception&) {
        // Said below.
      }
      if (!written)
        throw std::runtime_error(fmt::format("{} cannot be written: give a name ending in .png in a folder that exists", options_.png));
    }
    if (options_.json) return;
    fmt::print("{} pictures, {} robots at the end, at most {}\n", frames_, last_, most_);
    for (const auto& [name, total] : table.counters().all()) fmt::print("  {:<24} {}\n", name, total);
  }

 private:
  static std::optional<tracker::Point> pixel_of(const tracker::Track& track, const tracker::Calibration* camera) {
    return camera ? camera->to_pixel({track.in_arena.x_m, track.in_arena.y_m}, tracker::board_height_m) : std::nullopt;
  }
  static double seconds(hal::LabTime t) { return static_cast<double>(t.count()) * 1e-6; }

  static void print_json(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks, const tracker::Calibration* camera) {
    const auto number = [](double value, double steps) { return std::round(value * steps) / steps; };
    nlohmann::json robots = nlohmann::json::array();
    for (const tracker::Track& track : tracks) {
      nlohmann::json robot = {{"track", track.number},
                              {"x_m", number(track.in_arena.x_m, 1e6)},
                              {"y_m", number(track.in_arena.y_m, 1e6)},
                              {"heading_rad", track.heading_sigma_rad < 3 ? number(track.in_arena.heading_rad, 1e5) : std::nan("")},
                              {"led", name_of(track.led)},
                              {"confidence", number(static_cast<double>(track.confidence), 1e3)},
                              {"age_s", number(seconds(track.age), 1e3)},
                              {"doubtful", track.doubtful}};
      if (const auto at = pixel_of(track, camera)) robot["x_px"] = number(at->x, 1e3), robot["y_px"] = number(at->y, 1e3);
      robots.push_back(std::move(robot));
    }
    const nlohmann::json line = {{"frame", picture.number}, {"time_s", seconds(picture.stamp)}, {"robots", std::move(robots)}};
    fmt::print("{}\n", line.dump());
    std::fflush(stdout);
  }

  void write_rows(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks, const tracker::Calibration* camera) {
    for (const tracker::Track& track : tracks) {
      const auto at = pixel_of(track, camera);
      csv_ << fmt::format("{},{:.6f},{},{:.6f},{:.6f},{:.5f},{:.4f},{},{:.3f},{:.3f},{},{:.2f},{:.2f}\n", picture.number,
                          seconds(picture.stamp), track.number, track.in_arena.x_m, track.in_arena.y_m, track.in_arena.heading_rad, track.heading_sigma_rad,
                          name_of(track.led), track.confidence, seconds(track.age), track.doubtful ? 1 : 0, at ? at->x : std::nan(""),
                          at ? at->y : std::nan(""));
    }
  }

  // As a lab does, tracks' numbers in the place of ids.
  void publish(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks) {
    hal::PoseFrame frame{.stamp = picture.stamp, .number = picture.number, .robots = {}};
    for (const tracker::Track& track : tracks)
      frame.robots.push_back({track.number, track.in_arena, track.led, track.confidence, track.age});
    for (const auto& message : hal::to_messages(frame)) bus_->publish(hal::channel::poses, message);
  }

  void write_video(const cv::Mat& drawn) {
    if (!video_.isOpened()) {
      const bool jpegs = options_.video.ends_with(".avi");
      const int code = jpegs ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G') : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
      try {
        video_.open(options_.video, code, pictures_per_s_, drawn.size());
      } catch (const cv::Exception&) {
        // Said below.
      }
      if (!video_.isOpened())
        throw std::runtime_error(fmt::format("{} cannot be written: give a name ending in .mp4 or .avi in a folder that exists",
            options_.video));
    }
    video_.write(drawn);
  }

  void show(const cv::Mat& drawn) {
    std::vector<unsigned char> jpeg;
    if (!cv::imencode(".jpg", drawn, jpeg, {cv::IMWRITE_JPEG_QUALITY, 80})) return;
    server_->show("table", std::as_bytes(std::span(jpeg)));
  }

  const StreamOptions& options_;
  double pictures_per_s_;
  std::ofstream csv_;
  std::optional<hal::Bus> bus_;
  std::optional<hal::MjpegServer> server_;
  cv::VideoWriter video_;
  cv::Mat last_picture_;
  std::size_t frames_ = 0, most_ = 0, last_ = 0;
};

std::optional<tracker::CameraData> calibration_of(const StreamOptions& options) {
  if (options.calibration.empty()) return {};
  return tracker::read_calibration(options.calibration, options.camera);
}

tracker::TableTracker make_tracker(const StreamOptions& options, const std::optional<tracker::CameraData>& calibration) {
  tracker::TableSettings settings;
  settings.following.led_offset_rad = options.led_offset_deg * std::numbers::pi / 180;
  if (options.diameter_px > 0) settings.detection.diameter_px = options.diameter_px;
  if (calibration) return tracker::TableTracker({tracker::Calibration(*calibration)}, settings);
  return tracker::TableTracker(settings);
}

void refuse_other_size(const StreamOptions& options, const std::optional<tracker::CameraData>& calibration, const cv::Mat& picture) {
  if (!calibration || (picture.cols == calibration->lens.width_px && picture.rows == calibration->lens.height_px)) return;
  throw std::runtime_error(fmt::format("{} gives pictures of {} x {} pixels, and the calibration {} is for {} x {}; calibrate the "
                                       "camera at this resolution",
                                       options.source, picture.cols, picture.rows, options.calibration, calibration->lens.width_px,
                                       calibration->lens.height_px));
}

void track_recording(const StreamOptions& options) {
  const auto calibration = calibration_of(options);
  const auto recording = tracker::open_recording(options.source);
  tracker::TableTracker table = make_tracker(options, calibration);
  Outputs outputs(options, recording->pictures_per_s());
  Progress progress(std::filesystem::path(options.source).filename().string());
  const auto all = recording->pictures();
  const Moment begun = std::chrono::steady_clock::now();
  bool any = false;
  while (!interrupted) {
    const auto picture = recording->next();
    if (!picture || (options.seconds > 0 && picture->stamp.count() > options.seconds * 1e6)) break;
    refuse_other_size(options, calibration, picture->bgr);
    any = true;
    table.look(picture->stamp, std::span(&picture->bgr, 1));
    outputs.add(*picture, table);
    // Somebody who watches sees it at life speed.
    outputs.serve_until(outputs.serving() ? begun + picture->stamp : begun);
    if (all && !options.json && picture->number % 10 == 9) progress.show(picture->number + 1, *all, 1 / recording->pictures_per_s());
  }
  progress.done();
  if (!any) throw std::runtime_error(fmt::format("{} holds no picture that can be read", options.source));
  outputs.finish(table);
}

void track_camera(const StreamOptions& options) {
  const auto calibration = calibration_of(options);
  const tracker::Lens lens = calibration ? calibration->lens : tracker::Lens{};
  const auto camera = tracker::open_camera(options.source, lens.width_px, lens.height_px);
  tracker::TableTracker table = make_tracker(options, calibration);
  Outputs outputs(options, 15);
  const Moment begun = std::chrono::steady_clock::now();
  std::string trouble;
  std::uint32_t number = 0;
  while (!interrupted) {
    outputs.serve_until(std::chrono::steady_clock::now() + serve_every);
    const auto since = std::chrono::duration_cast<hal::LabTime>(std::chrono::steady_clock::now() - begun);
    if (options.seconds > 0 && since.count() > options.seconds * 1e6) break;
    const cv::Mat bgr = camera->newest();
    if (const std::string now = camera->trouble(); now != trouble && number > 0) {
      fmt::print(stderr, "arkmesh: {}\n", now.empty() ? "pictures come again" : now);
      trouble = now;
    }
    if (bgr.empty()) {
      if (number == 0 && since > first_picture_within) throw std::runtime_error(camera->trouble());
      continue;
    }
    trouble.clear();
    refuse_other_size(options, calibration, bgr);
    tracker::Picture picture{.bgr = bgr, .stamp = since, .number = number++, .name = {}};
    table.look(picture.stamp, std::span(&picture.bgr, 1));
    outputs.add(picture, table);
  }
  if (number == 0) throw std::runtime_error(camera->trouble());
  outputs.finish(table);
}

}  // namespace

void track_stream(const StreamOptions& options) {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  tracker::quieten_libraries();
  if (tracker::source_kind(options.source) == tracker::SourceKind::recording) track_recording(options);
  else track_camera(options);
}

}  // namespace arkmesh::cli
