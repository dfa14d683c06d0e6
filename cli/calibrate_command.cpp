// `arkmesh calibrate`: pictures of a chessboard and of the arena's corners in, a calibration file out, with its error
// in millimetres.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "cli/calibrate_options.hpp"
#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "testbed/camera_calibration.hpp"
#include "tracker/calibration_file.hpp"
#include "tracker/camera_fit.hpp"
#include "tracker/camera_guard.hpp"
#include "tracker/source.hpp"
#include "tracker/table_corners.hpp"

namespace arkmesh::cli {
namespace {

cv::Mat read_picture(const std::string& file) {
  cv::Mat picture = tracker::read_picture(file);
  if (picture.empty()) throw std::runtime_error(fmt::format("{} is damaged or no picture", file));
  return picture;
}

tracker::FittedLens fit_lens(const CalibrateOptions& options) {
  tracker::LensFit fit(options.chessboard());
  for (const std::string& file : options.pictures) {
    bool found = false;
    try {
      found = fit.add(read_picture(file));
    } catch (const std::runtime_error& wrong) {
      const std::string what = wrong.what();
      throw std::runtime_error(what.starts_with(file) ? what : fmt::format("{} {}", file, what));
    }
    fmt::print("{}: {}\n", file,
               found ? std::string("chessboard found")
                     : fmt::format("no whole chessboard with {} inner corners; left out", options.board));
    std::fflush(stdout);
  }
  return fit.fit();
}

cv::Mat arena_picture(const CalibrateOptions& options, const tracker::Lens& lens) {
  cv::Mat picture = read_picture(options.corner_picture);
  if (picture.cols != lens.width_px || picture.rows != lens.height_px)
    throw std::runtime_error(
        fmt::format("{} is {} x {} pixels, the chessboard pictures are {} x {}; use one camera at one resolution",
                    options.corner_picture, picture.cols, picture.rows, lens.width_px, lens.height_px));
  return picture;
}

std::vector<tracker::Point> corners_of(const CalibrateOptions& options, const tracker::Lens& lens) {
  std::vector<tracker::Point> corners = options.given_corners();
  if (!corners.empty()) return corners;
  if (options.corner_picture.empty())
    throw CLI::ValidationError("--corner",
                               "give the arena's corners: four times --corner x,y, or a picture with --corners");
  const cv::Mat picture = arena_picture(options, lens);
  corners = tracker::find_table_corners(picture);
  if (corners.empty())
    throw std::runtime_error(
        fmt::format("{}: no arena stands out from its surroundings; give its corners with --corner x,y, four times",
                    options.corner_picture));
  for (const tracker::Point& at : corners) fmt::print("corner {:.1f},{:.1f}\n", at.x, at.y);
  return corners;
}

void draw_check(const CalibrateOptions& options, const tracker::CameraData& data) {
  if (options.png.empty()) return;
  cv::Mat picture = options.corner_picture.empty()
                        ? cv::Mat(data.lens.height_px, data.lens.width_px, CV_8UC3, cv::Scalar::all(60))
                        : read_picture(options.corner_picture);
  testbed::draw_arena(picture, data);
  tracker::write_picture(options.png, picture);
}

// What a lab compares its first pictures with.
std::vector<tracker::Landmark> landmarks_in(const CalibrateOptions& options, const tracker::CameraData& data) {
  std::vector<tracker::Landmark> found;
  if (!options.corner_picture.empty()) found = testbed::landmarks_of(arena_picture(options, data.lens), data);
  const bool enough = found.size() >= tracker::CameraGuard::fewest_marks;
  fmt::print("landmarks of the arena: {}{}\n", found.size(),
             enough                           ? ", by which a lab notices that the camera was moved since"
             : options.corner_picture.empty() ? "; without a picture (--corners) a lab cannot notice that the camera "
                                                "was moved since"
                                              : ", too few to notice that the camera was moved since; stick some small "
                                                "dark dots near the arena's border and take the picture again");
  return found;
}

std::string robot_width(const tracker::CameraData& data, tracker::Point at) {
  const auto width_px = testbed::robot_width_px(data, at);
  if (!width_px) return "";
  return fmt::format(": a robot there is {:.1f} px wide{}", *width_px,
                     *width_px < 12 ? ", too few: bring the camera nearer, or take more pixels" : "");
}

void calibrate(const CalibrateOptions& options) {
  const auto [width_m, height_m] = options.arena_sides_m();
  if (options.pictures.empty())
    throw CLI::ValidationError("PICTURES", "give pictures of a chessboard, or --import-ark FILE");
  const tracker::FittedLens lens = fit_lens(options);
  const bool fisheye = lens.lens.model == tracker::LensModel::fisheye;
  fmt::print(
      "lens: {}, focal length {:.1f} x {:.1f} px, error {:.3f} px = {:.3f} mm on the boards ({} pictures; as {}: "
      "{:.3f} px)\n",
      fisheye ? "fisheye" : "pinhole", lens.lens.matrix[0], lens.lens.matrix[4], lens.error_px, lens.error_mm,
      lens.pictures, fisheye ? "pinhole" : "fisheye", lens.other_error_px);
  const std::vector<tracker::Mark> landmarks = options.given_landmarks();
  const tracker::CameraData data =
      landmarks.empty() ? tracker::place_camera(lens.lens, corners_of(options, lens.lens), width_m, height_m)
                        : tracker::place_camera(lens.lens, landmarks, width_m, height_m);
  const tracker::Calibration camera(data);
  const auto place = camera.position_m();
  fmt::print("camera: {:.3f} m above the arena, over {:.3f},{:.3f}; {} off by {:.2f} px = {:.2f} mm\n", place[2],
             place[0], place[1], landmarks.empty() ? "corners" : "landmarks", data.error_px, data.error_mm);
  if (const std::string width = robot_width(data, {0, 0}); !width.empty()) fmt::print("the arena's middle{}\n", width);
  draw_check(options, data);
  const std::size_t cameras = testbed::put_into(options.out, {options.name, data, landmarks_in(options, data)});
  fmt::print("{}: {} camera{} ({})\n", options.out, cameras, cameras == 1 ? "" : "s", options.name);
}

void import_ark(const CalibrateOptions& options) {
  const auto [width_m, height_m] = options.arena_sides_m();
  tracker::ArkTable table;
  std::tie(table.width_px, table.height_px) = options.ark_picture_px();
  table.overview_px = std::min(table.width_px, table.height_px);
  table.arena_width_m = width_m;
  table.arena_height_m = height_m;
  table.camera_height_m = options.camera_height_m;
  std::vector<tracker::NamedCamera> cameras;
  for (const tracker::CameraData& data : tracker::import_ark_calibration(options.ark, table)) {
    cameras.push_back({fmt::format("camera{}", cameras.size()), data, {}});
    const auto place = tracker::Calibration(data).position_m();
    fmt::print("camera{}: over {:.3f},{:.3f}{}\n", cameras.size() - 1, place[0], place[1],
               robot_width(data, {place[0], place[1]}));
  }
  tracker::write_calibrations(options.out, cameras);
  fmt::print("{}: {} cameras\n", options.out, cameras.size());
}

}  // namespace

void add_calibrate_command(CLI::App& app) {
  auto* command = add_command(app, "calibrate");
  const auto options = std::make_shared<CalibrateOptions>();
  options->add_to(*command);
  command->footer(
      "Examples:\n  arkmesh calibrate board*.png --board 7x6 --square-mm 25 --corners arena.png --arena 1x1 --out "
      "testbed.yaml\n"
      "  arkmesh calibrate --import-ark calibration.xml --arena 2x2 --out testbed.yaml");
  command->callback([options] {
    tracker::quieten_libraries();
    options->ark.empty() ? calibrate(*options) : import_ark(*options);
  });
}

}  // namespace arkmesh::cli
