// `arkmesh track SOURCE`: the robots on a picture or on each picture of a folder, as a table or as JSON, and drawn over
// the picture; of what moves (videos, cameras, clips) it follows them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/progress_line.hpp"
#include "testbed/robots_on_picture.hpp"
#include "testbed/track_stream.hpp"
#include "tracker/camera/source.hpp"
#include "tracker/detect/detector.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds shown_after{2};  // what takes no longer needs no progress

double led_offset_rad(const testbed::StreamOptions& options) {
  return options.led_offset_deg * std::numbers::pi / 180;
}

// Each picture by itself: pictures of a folder need not be of one camera. Draws into `png` unless that is empty.
std::vector<tracker::Detection> look_at(const cv::Mat& bgr, const testbed::StreamOptions& options,
                                        const fs::path& png) {
  tracker::DetectorSettings settings;
  if (options.diameter_px > 0) settings.diameter_px = options.diameter_px;
  // People tell it roughly.
  settings.diameter_told = true;
  tracker::Explanation explanation;
  std::vector<tracker::Detection> robots =
      tracker::Detector(settings).search(bgr, options.explain.empty() ? nullptr : &explanation);
  if (!options.explain.empty()) tracker::write_picture(options.explain, testbed::explained(bgr, robots, explanation));
  if (!png.empty()) tracker::write_picture(png, testbed::with_robots_drawn(bgr, robots, led_offset_rad(options)));
  return robots;
}

void track_picture(const testbed::StreamOptions& options) {
  const cv::Mat bgr = tracker::read_picture(options.source);
  if (bgr.empty())
    throw std::runtime_error(fmt::format("{} {}: give a PNG, JPEG, BMP or TIFF file of fewer than 2^30 pixels",
                                         options.source, tracker::no_picture));
  const std::vector<tracker::Detection> robots = look_at(bgr, options, options.png);
  if (robots.empty()) fmt::print(stderr, "arkmesh: {}\n", testbed::nothing_found(options.diameter_px));
  const double offset_rad = led_offset_rad(options);
  if (options.json)
    fmt::print("{}\n", testbed::robots_as_json(robots, offset_rad).dump(2));
  else
    fmt::print("{}", testbed::robots_as_text(robots, offset_rad));
}

// False when a picture could not be read; the others are done nevertheless.
bool track_folder(const testbed::StreamOptions& options) {
  const std::vector<fs::path> files = tracker::pictures_of(options.source);
  if (!options.png.empty() && !fs::is_directory(options.png))
    throw std::runtime_error(
        fmt::format("--png {} is not a folder: for a folder of pictures give a folder that exists", options.png));
  const double offset_rad = led_offset_rad(options);
  nlohmann::json all = nlohmann::json::array();
  ProgressLine status;
  OperatorStop stop;
  const auto begun = std::chrono::steady_clock::now();
  std::size_t damaged = 0, found = 0;
  for (std::size_t i = 0; i < files.size() && !stop.stopped(); ++i) {
    const fs::path& file = files[i];
    if (std::chrono::steady_clock::now() - begun > shown_after)
      status.show(fmt::format("picture {} of {}: {}", i + 1, files.size(), file.filename().string()));
    const cv::Mat bgr = tracker::read_picture(file);
    if (bgr.empty()) {
      status.done();
      fmt::print(stderr, "arkmesh: {} {}; left out\n", file.string(), tracker::no_picture);
      ++damaged;
      continue;
    }
    const std::vector<tracker::Detection> robots = look_at(
        bgr, options, options.png.empty() ? fs::path() : fs::path(options.png) / (file.stem().string() + ".png"));
    found += robots.size();
    if (options.json)
      all.push_back({{"picture", file.filename().string()}, {"robots", testbed::robots_as_json(robots, offset_rad)}});
    status.done();
    if (!options.json) fmt::print("{}:\n{}", file.filename().string(), testbed::robots_as_text(robots, offset_rad));
  }
  if (options.json) fmt::print("{}\n", all.dump(2));
  if (found == 0) fmt::print(stderr, "arkmesh: {}\n", testbed::nothing_found(options.diameter_px));
  return damaged == 0;
}

bool follow(const testbed::StreamOptions& options, const std::string& name) {
  OperatorStop stop;
  ProgressLine progress(name, "picture");
  return testbed::track_stream(options, stop, progress);
}

// False when something could not be read, which was said.
bool track(const testbed::StreamOptions& options) {
  const auto explains = [&](bool one_picture) {
    if (!options.explain.empty() && !one_picture)
      throw std::runtime_error(
          fmt::format("--explain needs one picture: {} is not a picture, or is tracked as a video", options.source));
  };
  if (tracker::source_kind(options.source) != tracker::SourceKind::recording) {
    explains(false);
    return follow(options, "");
  }
  std::error_code failed;
  const fs::file_status status = fs::status(options.source, failed);
  if (!fs::exists(status))
    throw std::runtime_error(fmt::format(
        "there is no {}: give a picture, a folder of pictures, a video, a camera's number or a URL", options.source));
  const bool follows = !options.csv.empty() || !options.video.empty() || options.serve_port >= 0 ||
                       !options.publish.empty() || !options.calibration.empty();
  const bool picture = !fs::is_directory(status) && tracker::is_picture_name(options.source);
  explains(picture && !follows);
  if (follows || (!fs::is_directory(status) && !picture))
    return follow(options, fs::path(options.source).filename().string());
  if (fs::is_directory(status)) return track_folder(options);
  track_picture(options);
  return true;
}

}  // namespace

void add_track_command(CLI::App* command) {
  const auto options = std::make_shared<testbed::StreamOptions>();
  command
      ->add_option("SOURCE", options->source,
                   "A picture, a folder of pictures, a video, a camera's number or device, or a URL")
      ->required();
  command->add_flag(
      "--json", options->json,
      "Print a JSON list (of a folder: a list of {picture, robots}; of a video or camera: a line for each picture)");
  command->add_option("--png", options->png,
                      "Write the picture with the robots drawn on it (of a folder: into this folder; of a video or "
                      "camera: the last picture)");
  command->add_option("--explain", options->explain,
                      "For an image: draw detections, rejected candidates with reasons, and the evidence for the size");
  auto* calibration = command->add_option(
      "--calibration", options->calibration,
      "Measure in the arena with this file of arkmesh calibrate; otherwise metres are derived from the robots' size");
  command->add_option("--camera", options->camera, "The camera's name in that file, when it holds several")
      ->needs(calibration);
  command->add_option("--csv", options->csv, "Write a row for each robot and picture");
  command->add_option("--video", options->video, "Write a video with the robots drawn on it (.mp4 or .avi)");
  command->add_option("--serve", options->serve_port, "Show it live in browsers: http://127.0.0.1:PORT/arena")
      ->check(CLI::Range(0, 65535));
  command->add_option("--publish", options->publish, "Publish poses on this LCM bus, with the tracks' numbers as ids");
  command->add_option("--seconds", options->seconds, "Duration in seconds")->check(CLI::Range(0.0, 1e7));
  command
      ->add_option("--led-offset", options->led_offset_deg,
                   "Driving direction minus direction of the LED, degrees counter-clockwise")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  command->add_option("--diameter", options->diameter_px, "Diameter of a robot in pixels, if known")
      ->check(CLI::Range(6.0, 2000.0));
  command->footer(
      "Examples:\n  arkmesh track robots.png --json --png found.png\n  arkmesh track clip.mp4 --csv tracks.csv --video "
      "drawn.mp4\n"
      "  arkmesh track 0 --calibration testbed.yaml --serve 8095\n"
      "With --json a picture's robots are a list of {x_px, y_px, r_px, led, led_x_px, led_y_px, heading_rad, "
      "led_heading_rad}; heading_rad "
      "is the\n"
      "driving direction, led_heading_rad that of the LED, and values that an unlit LED leaves unknown are null.\n"
      "A folder is tracked as a video with any of --csv, --video, --serve, --publish, --calibration; otherwise\n"
      "robots are found in each picture separately.\n"
      "Pixels: x right, y down, the centre of the top-left pixel is (0, 0). Angles: counter-clockwise from the "
      "picture's right.");
  command->callback([options] {
    tracker::quieten_libraries();
    end_with(track(*options) ? 0 : 1);
  });
}

}  // namespace arkmesh::cli
