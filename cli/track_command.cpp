// `arkmesh track SOURCE`: the robots on a picture or on each picture of a folder, as a table or as JSON, and drawn over the picture.
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
#include "tracker/detector.hpp"

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
  if (bgr.empty()) throw std::runtime_error(fmt::format("{} is not a picture that can be read: give a PNG, JPEG, BMP or TIFF file", file.string()));
  return bgr;
}

bool looks_like_picture(const fs::path& file) {
  std::string end = file.extension().string();
  std::transform(end.begin(), end.end(), end.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return end == ".png" || end == ".jpg" || end == ".jpeg" || end == ".bmp" || end == ".tif" || end == ".tiff" || end == ".webp" || end == ".ppm";
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
  if (!written) throw std::runtime_error(fmt::format("{} cannot be written: give a name ending in .png in a folder that exists", file.string()));
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
    if (!options.png.empty()) write_picture(fs::path(options.png) / (file.stem().string() + ".png"), with_robots_drawn(bgr, robots, offset_rad));
    if (options.json) all.push_back({{"picture", file.filename().string()}, {"robots", robots_as_json(robots, offset_rad)}});
    else fmt::print("{}:\n{}", file.filename().string(), robots_as_text(robots, offset_rad));
  }
  if (options.json) fmt::print("{}\n", all.dump(2));
}

}  // namespace

void add_track_command(CLI::App& app) {
  auto* track = app.add_subcommand("track", "Finds the robots on a picture or on each picture of a folder");
  const auto options = std::make_shared<TrackOptions>();
  track->add_option("SOURCE", options->source, "A picture, or a folder of pictures")->required();
  track->add_flag("--json", options->json, "Print a JSON list (of a folder: a list of {picture, robots})");
  track->add_option("--png", options->png, "Write the picture with the robots drawn on it (of a folder: into this folder)");
  track->add_option("--led-offset", options->led_offset_deg, "Driving direction minus direction of the LED, degrees counter-clockwise")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  track->add_option("--diameter", options->diameter_px, "Diameter of a robot in pixels, where it is known")->check(CLI::Range(6.0, 2000.0));
  track->footer("Example:\n  arkmesh track table.png --json --png found.png\n"
                "Pixels: x right, y down, the centre of the top-left pixel is (0, 0). Angles: counter-clockwise from the picture's right.");
  track->callback([options] {
    std::error_code failed;
    const fs::file_status status = fs::status(options->source, failed);
    if (!fs::exists(status)) throw std::runtime_error(fmt::format("there is no file or folder {}", options->source));
    if (fs::is_directory(status)) track_folder(*options);
    else track_picture(*options);
  });
}

}  // namespace arkmesh::cli
