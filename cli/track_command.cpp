// `arkmesh track SOURCE`: the robots on a picture or on each picture of a folder, as a table or as JSON, and drawn over the picture; of
// what moves (videos, cameras, clips) it follows them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/robots_on_picture.hpp"
#include "cli/track_stream.hpp"
#include "tracker/detector.hpp"
#include "tracker/source.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

struct TrackOptions {
  std::string source, png;
  bool json = false;
  double led_offset_deg = 44, diameter_px = 0;
};

cv::Mat read_picture(const fs::path& file) {
  cv::Mat bgr;
  try {
    bgr = cv::imread(file.string(), cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    throw std::runtime_error(fmt::format("{} is a damaged or too large picture: fewer than 2^30 pixels can be read", file.string()));
  }
  if (bgr.empty())
    throw std::runtime_error(fmt::format("{} is not a picture that can be read: give a PNG, JPEG, BMP or TIFF file", file.string()));
  return bgr;
}

bool looks_like_picture(const fs::path& file) {
  std::string end = file.extension().string();
  std::transform(end.begin(), end.end(), end.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return end == ".png" || end == ".jpg" || end == ".jpeg" || end == ".bmp" || end == ".tif" || end == ".tiff" || end == ".webp" ||
         end == ".ppm";
}

std::vector<fs::path> pictures_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && looks_like_picture(entry.path())) files.push_back(entry.path());
  if (files.empty()) throw std::runtime_error(fmt::format("the folder {} holds no pictures: put PNG or JPEG files there", folder.string()));
  std::sort(files.begin(), files.end());
  return files;
}

void write_picture(const fs::path& file, const cv::Mat& bgr) {
  bool written = false;
  try {
    written = cv::imwrite(file.string(), bgr);
  } catch (const cv::Exception&) {
    // said below
  }
  if (!written)
    throw std::runtime_error(fmt::format("{} cannot be written: give a name ending in .png in a folder that exists", file.string()));
}

// Each picture by itself: pictures of a folder need not be of one camera.
std::vector<tracker::Detection> look_at(const cv::Mat& bgr, const TrackOptions& options) {
  tracker::DetectorSettings settings;
  if (options.diameter_px > 0) settings.diameter_px = options.diameter_px;
  return tracker::Detector(settings).search(bgr);
}

void track_picture(const TrackOptions& options) {
  const cv::Mat bgr = read_picture(options.source);
  const std::vector<tracker::Detection> robots = look_at(bgr, options);
  const double offset_rad = options.led_offset_deg * std::numbers::pi / 180;
  if (!options.png.empty()) write_picture(options.png, with_robots_drawn(bgr, robots, offset_rad));
  if (options.json) fmt::print("{}\n", robots_as_json(robots, offset_rad).dump(2));
  else fmt::print("{}", robots_as_text(robots, offset_rad));
}

void track_folder(const TrackOptions& options) {
  const std::vector<fs::path> files = pictures_of(options.source);
  if (!options.png.empty() && !fs::is_directory(options.png))
    throw std::runtime_error(fmt::format("--png {} is not a folder: for a folder of pictures give a folder that exists", options.png));
  const double offset_rad = options.led_offset_deg * std::numbers::pi / 180;
  nlohmann::json all = nlohmann::json::array();
  for (const fs::path& file : files) {
    const cv::Mat bgr = read_picture(file);
    const std::vector<tracker::Detection> robots = look_at(bgr, options);
    if (!options.png.empty())
      write_picture(fs::path(options.png) / (file.stem().string() + ".png"), with_robots_drawn(bgr, robots, offset_rad));
    if (options.json) all.push_back({{"picture", file.filename().string()}, {"robots", robots_as_json(robots, offset_rad)}});
    else fmt::print("{}:\n{}", file.filename().string(), robots_as_text(robots, offset_rad));
  }
  if (options.json) fmt::print("{}\n", all.dump(2));
}

}  // namespace

void add_track_command(CLI::App& app) {
  auto* track = app.add_subcommand("track", "Finds the robots on pictures; follows them in videos and before cameras");
  const auto options = std::make_shared<TrackOptions>();
  const auto stream = std::make_shared<StreamOptions>();
  track->add_option("SOURCE", options->source, "A picture, a folder of pictures, a video, a camera's number or device, or a URL")
      ->required();
  track->add_flag("--json", options->json,
                  "Print a JSON list (of a folder: a list of {picture, robots}; of what moves: a line for each picture)");
  track->add_option("--png", options->png,
                    "Write the picture with the robots drawn on it (of a folder: into this folder; of what moves: the last)");
  track->add_option("--calibration", stream->calibration,
                    "Measure in the arena with this file of arkmesh calibrate; else in robots' bodies");
  track->add_option("--camera", stream->camera, "The camera's name in that file, when it holds several");
  track->add_option("--csv", stream->csv, "Write a row for each robot and picture");
  track->add_option("--video", stream->video, "Write a video with the robots drawn on it (.mp4 or .avi)");
  track->add_option("--serve", stream->serve_port, "Show it live in browsers: http://127.0.0.1:PORT/table")->check(CLI::Range(0, 65535));
  track->add_option("--publish", stream->publish, "Publish poses on this LCM bus, tracks' numbers as ids");
  track->add_option("--seconds", stream->seconds, "End after so many seconds")->check(CLI::Range(0.0, 1e7));
  track->add_option("--led-offset", options->led_offset_deg, "Driving direction minus direction of the LED, degrees counter-clockwise")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  track->add_option("--diameter", options->diameter_px, "Diameter of a robot in pixels, where it is known")->check(CLI::Range(6.0, 2000.0));
  track->footer(
      "Examples:\n  arkmesh track table.png --json --png found.png\n  arkmesh track clip.mp4 --csv tracks.csv --video drawn.mp4\n"
      "  arkmesh track 0 --calibration table.yaml --serve 8095\n"
      "A folder is followed as a clip with any of --csv, --video, --serve, --publish, --calibration; else each picture stands for itself.\n"
      "Pixels: x right, y down, the centre of the top-left pixel is (0, 0). Angles: counter-clockwise from the picture's right.");
  track->callback([options, stream] {
    stream->source = options->source;
    stream->png = options->png;
    stream->json = options->json;
    stream->led_offset_deg = options->led_offset_deg;
    stream->diameter_px = options->diameter_px;
    if (tracker::source_kind(options->source) != tracker::SourceKind::recording) return track_stream(*stream);
    std::error_code failed;
    const fs::file_status status = fs::status(options->source, failed);
    if (!fs::exists(status)) throw std::runtime_error(fmt::format("there is no file or folder {}", options->source));
    const bool follow = !stream->csv.empty() || !stream->video.empty() || stream->serve_port >= 0 || !stream->publish.empty() ||
                        !stream->calibration.empty();
    if (follow || (!fs::is_directory(status) && !looks_like_picture(options->source))) track_stream(*stream);
    else if (fs::is_directory(status)) track_folder(*options);
    else track_picture(*options);
  });
}

}  // namespace arkmesh::cli
