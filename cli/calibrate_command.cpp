// `arkmesh calibrate`: pictures of a chessboard and of the arena's corners in, a calibration file out, with its error
// in millimetres.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cli/calibrate_options.hpp"
#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "testbed/camera_set_up.hpp"
#include "tracker/calibration_file.hpp"
#include "tracker/source.hpp"

namespace arkmesh::cli {
namespace {

tracker::FittedLens fit_lens(const CalibrateOptions& options) {
  return testbed::fit_lens(options.pictures, board_of(options), [&](const std::string& picture, bool found) {
    fmt::print("{}: {}\n", picture,
               found ? std::string("chessboard found")
                     : fmt::format("no whole chessboard with {} inner corners; left out", options.board));
    std::fflush(stdout);
  });
}

std::vector<tracker::Point> corners_of(const CalibrateOptions& options, const tracker::Lens& lens) {
  std::vector<tracker::Point> corners = given_corners(options);
  if (!corners.empty()) return corners;
  if (options.corner_picture.empty())
    throw CLI::ValidationError("--corner",
                               "give the arena's corners: four times --corner x,y, or a picture with --corners");
  corners = testbed::find_corners(options.corner_picture, lens);
  for (const tracker::Point& at : corners) fmt::print("corner {:.1f},{:.1f}\n", at.x, at.y);
  return corners;
}

// How large a robot is in the picture there.
std::string robot_width(const tracker::CameraData& data, tracker::Point at) {
  const auto width_px = testbed::robot_width_px(data, at);
  if (!width_px) return "";
  return fmt::format(": a robot there is {:.1f} px wide{}", *width_px,
                     *width_px < 12 ? ", too few: bring the camera nearer, or take more pixels" : "");
}

void calibrate(const CalibrateOptions& options) {
  const auto [width_m, height_m] = sides_of(options);
  if (options.pictures.empty())
    throw CLI::ValidationError("PICTURES", "give pictures of a chessboard, or --import-ark FILE");
  const tracker::FittedLens lens = fit_lens(options);
  const bool fisheye = lens.lens.model == tracker::LensModel::fisheye;
  fmt::print(
      "lens: {}, focal length {:.1f} x {:.1f} px, error {:.3f} px = {:.3f} mm on the boards ({} pictures; as {}: "
      "{:.3f} px)\n",
      fisheye ? "fisheye" : "pinhole", lens.lens.matrix[0], lens.lens.matrix[4], lens.error_px, lens.error_mm,
      lens.pictures, fisheye ? "pinhole" : "fisheye", lens.other_error_px);
  const std::vector<tracker::Mark> marks = marks_of(options);
  const tracker::CameraData data =
      marks.empty() ? tracker::place_camera(lens.lens, corners_of(options, lens.lens), width_m, height_m)
                    : tracker::place_camera(lens.lens, marks, width_m, height_m);
  const tracker::Calibration camera(data);
  const auto place = camera.position_m();
  fmt::print("camera: {:.3f} m above the table, over {:.3f},{:.3f}; {} off by {:.2f} px = {:.2f} mm\n", place[2],
             place[0], place[1], marks.empty() ? "corners" : "marks", data.error_px, data.error_mm);
  if (const std::string width = robot_width(data, {0, 0}); !width.empty()) fmt::print("the arena's middle{}\n", width);
  if (!options.png.empty()) testbed::draw_arena(options.png, options.corner_picture, data);
  const std::size_t cameras = testbed::keep_camera(options.out, {options.name, data});
  fmt::print("{}: {} camera{} ({})\n", options.out, cameras, cameras == 1 ? "" : "s", options.name);
}

void import_ark(const CalibrateOptions& options) {
  const auto [width_m, height_m] = sides_of(options);
  const auto [width_px, height_px] = picture_size_of(options);
  tracker::ArkTable table;
  table.width_px = width_px;
  table.height_px = height_px;
  table.overview_px = std::min(table.width_px, table.height_px);
  table.arena_width_m = width_m;
  table.arena_height_m = height_m;
  table.camera_height_m = options.camera_height_m;
  std::vector<tracker::NamedCamera> cameras;
  for (const tracker::CameraData& data : tracker::import_ark_calibration(options.ark, table)) {
    cameras.push_back({fmt::format("camera{}", cameras.size()), data});
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
  command
      ->add_option("PICTURES", options->pictures,
                   "Pictures of a chessboard, at different slants, all over the camera's view")
      ->check(CLI::ExistingFile);
  command->add_option("--board", options->board, "Inner corners of the chessboard, columns x rows")
      ->capture_default_str();
  command->add_option("--square-mm", options->square_mm, "Side of one of its squares")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command->add_option("--arena", options->arena, "Width x height of the arena in metres, along x (east) and y (north)")
      ->capture_default_str();
  command->add_option("--corner", options->corners,
                      "A corner of the arena in pixels, x,y; four times, from the north-west one clockwise");
  command
      ->add_option("--corners", options->corner_picture,
                   "A picture of the whole table; without --corner its corners are looked for, the upper left "
                   "one being north-west")
      ->check(CLI::ExistingFile);
  command
      ->add_option("--mark", options->marks,
                   "A point of the table, where the picture shows it and where it is: x,y=x,y in pixels and metres (x "
                   "east, y north of the "
                   "arena's middle); "
                   "four times or more, spread over the view, for a camera that does not see all four corners")
      ->excludes("--corner");
  command->add_option("--name", options->name, "The camera's name in the file")->capture_default_str();
  command->add_option("--png", options->png, "Draw the arena over the picture of the table, to see whether it fits");
  command->add_option("--out", options->out, "The calibration file (.yaml); other cameras in it are kept")->required();
  auto* ark = command->add_option("--import-ark", options->ark, "Take an ARK calibration over instead")
                  ->check(CLI::ExistingFile);
  command->add_option("--camera-height", options->camera_height_m, "Metres of ARK's cameras above the table")
      ->check(CLI::Range(0.1, 50.0))
      ->needs(ark)
      ->capture_default_str();
  command->add_option("--size", options->size, "Pictures of ARK's cameras, width x height in pixels")
      ->needs(ark)
      ->capture_default_str();
  command->footer(
      "Examples:\n  arkmesh calibrate board*.png --board 7x6 --square-mm 25 --corners table.png --arena 1x1 --out "
      "table.yaml\n"
      "  arkmesh calibrate --import-ark calibration.xml --arena 2x2 --out table.yaml");
  command->callback([options] {
    tracker::quieten_libraries();
    options->ark.empty() ? calibrate(*options) : import_ark(*options);
  });
}

}  // namespace arkmesh::cli
