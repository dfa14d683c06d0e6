// `arkmesh calibrate`: pictures of a chessboard and of the arena's corners in, a calibration file out, with its error
// in millimetres.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "hal/counted.hpp"
#include "testbed/camera_calibration.hpp"
#include "tracker/camera/arena_corners.hpp"
#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/camera_fit.hpp"
#include "tracker/camera/camera_guard.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::cli {
namespace {

// "7x6" or "120.5,33": two numbers above or at 0 and nothing else.
std::pair<double, double> two_positive(const std::string& text, char between, const std::string& option,
                                       const std::string& example) {
  const auto both = two_numbers(text, between);
  if (!both || !(both->first >= 0) || !(both->second >= 0))
    throw CLI::ValidationError(option, fmt::format("{} is not of the form {}", text, example));
  return *both;
}

struct CalibrateOptions {
  std::vector<std::string> pictures, corners, landmarks;
  std::string board = "7x6", arena = "1x1", corner_picture, out, name = "camera0", png, ark, intrinsics,
              size = "2048x1536";
  double square_mm = 25, camera_height_m = 1.6;

  // All of these throw CLI::ValidationError.
  std::pair<double, double> arena_sides_m() const {
    const auto sides = two_positive(arena, 'x', "--arena", "1x1 (metres)");
    if (!(sides.first > 0 && sides.second > 0 && sides.first <= 100 && sides.second <= 100))
      throw CLI::ValidationError("--arena", "the sides must be above 0 and at most 100 m");
    return sides;
  }

  tracker::ChessboardSize chessboard() const {
    const auto [columns, rows] = two_positive(board, 'x', "--board", "7x6 (inner corners)");
    if (columns < 3 || rows < 3 || columns > 50 || rows > 50 || columns != static_cast<int>(columns) ||
        rows != static_cast<int>(rows))
      throw CLI::ValidationError("--board", "a chessboard has 3 to 50 inner corners along each side");
    return {static_cast<int>(columns), static_cast<int>(rows), square_mm};
  }

  std::pair<int, int> ark_picture_px() const {
    const auto [width_px, height_px] = two_positive(size, 'x', "--size", "2048x1536 (pixels)");
    if (width_px < 1 || height_px < 1 || width_px > 100'000 || height_px > 100'000)
      throw CLI::ValidationError("--size", "no camera takes pictures of this size");
    return {static_cast<int>(width_px), static_cast<int>(height_px)};
  }

  std::vector<tracker::Point> given_corners() const {
    std::vector<tracker::Point> found;
    for (const std::string& text : corners) {
      const auto [x, y] = two_positive(text, ',', "--corner", "120.5,33 (pixels)");
      found.push_back({x, y});
    }
    return found;
  }

  // "812.5,64=-0.25,0.5": pixels, and metres of the arena frame.
  std::vector<tracker::Mark> given_landmarks() const {
    std::vector<tracker::Mark> found;
    for (const std::string& text : landmarks) {
      tracker::Mark mark;
      char rest = 0;
      const int read = std::sscanf(text.c_str(), "%lf,%lf=%lf,%lf%c", &mark.in_pixels.x, &mark.in_pixels.y,
                                   &mark.in_arena.x, &mark.in_arena.y, &rest);
      const double numbers[] = {mark.in_pixels.x, mark.in_pixels.y, mark.in_arena.x, mark.in_arena.y};
      if (read != 4 ||
          !std::all_of(std::begin(numbers), std::end(numbers), [](double number) { return std::abs(number) < 1e5; }))
        throw CLI::ValidationError(
            "--landmark",
            fmt::format("{} is not of the form 812.5,64=-0.25,0.5 (pixels=metres of the arena frame)", text));
      found.push_back(mark);
    }
    return found;
  }
};

constexpr double worst_error_px = 2;  // of corners or landmarks: else one was clicked or measured wrongly
constexpr int uncertain_code = 4;     // written, with a warning

cv::Mat read_picture(const std::string& file) {
  cv::Mat picture = tracker::read_picture(file);
  if (picture.empty()) throw std::runtime_error(fmt::format("{} {}", file, tracker::no_picture));
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
                     : fmt::format("no complete chessboard with {} inner corners; skipped", options.board));
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
  corners = tracker::find_arena_corners(picture);
  if (corners.empty())
    throw std::runtime_error(fmt::format(
        "{}: the arena does not stand out from its surroundings; give its corners with --corner x,y, four times",
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
             enough ? ", with which a lab detects a moved camera"
             : options.corner_picture.empty()
                 ? "; without a picture (--corners) a lab cannot detect a moved camera"
                 : ", too few to detect a moved camera; stick some small dark dots near the arena's border "
                   "and take the picture again");
  return found;
}

std::string robot_width(const tracker::CameraData& data, tracker::Point at) {
  const auto width_px = testbed::robot_width_px(data, at);
  if (!width_px) return "";
  return fmt::format(": a robot there is {:.1f} px wide{}", *width_px,
                     *width_px < 12 ? ", too few: move the camera closer, or use a higher resolution" : "");
}

// Of the pictures of a chessboard, or of a file; what is uncertain of it is added to `doubts`.
tracker::Lens lens_of(const CalibrateOptions& options, std::vector<std::string>& doubts) {
  if (options.pictures.empty() == options.intrinsics.empty())
    throw CLI::ValidationError("PICTURES",
                               "give either pictures of a chessboard, --intrinsics FILE or --import-ark FILE");
  if (!options.intrinsics.empty()) return tracker::read_intrinsics(options.intrinsics);
  const tracker::FittedLens lens = fit_lens(options);
  doubts = lens.doubts;
  const bool fisheye = lens.lens.model == tracker::LensModel::fisheye;
  fmt::print(
      "lens: {}, focal length {:.1f} x {:.1f} px, error {:.3f} px = {:.3f} mm on the boards ({}; as {}: "
      "{:.3f} px)\n",
      fisheye ? "fisheye" : "pinhole", lens.lens.matrix[0], lens.lens.matrix[4], lens.error_px, lens.error_mm,
      hal::counted(lens.pictures, "picture"), fisheye ? "pinhole" : "fisheye", lens.other_error_px);
  return lens.lens;
}

// False: it was written with a number that is uncertain, which was said.
bool calibrate(const CalibrateOptions& options) {
  const auto [width_m, height_m] = options.arena_sides_m();
  std::vector<std::string> doubts;
  const tracker::Lens lens = lens_of(options, doubts);
  const std::vector<tracker::Mark> landmarks = options.given_landmarks();
  const tracker::CameraData data = landmarks.empty()
                                       ? tracker::place_camera(lens, corners_of(options, lens), width_m, height_m)
                                       : tracker::place_camera(lens, landmarks, width_m, height_m);
  const tracker::Calibration camera(data);
  const auto place = camera.position_m();
  fmt::print("camera: {:.3f} m above the arena, over {:.3f},{:.3f}; {} off by {:.2f} px = {:.2f} mm\n", place[2],
             place[0], place[1], landmarks.empty() ? "corners" : "landmarks", data.error_px, data.error_mm);
  if (const std::string width = robot_width(data, {0, 0}); !width.empty()) fmt::print("the arena's centre{}\n", width);
  draw_check(options, data);
  const std::size_t cameras = testbed::put_into(options.out, {options.name, data, landmarks_in(options, data)});
  fmt::print("{}: {} ({})\n", options.out, hal::counted(cameras, "camera"), options.name);
  if (data.error_px > worst_error_px)
    doubts.push_back(fmt::format("{} are off by {:.1f} px, {:.1f} mm; check their pixels and --arena",
                                 landmarks.empty() ? "the corners" : "the landmarks", data.error_px, data.error_mm));
  std::fflush(stdout);
  for (const std::string& doubt : doubts) fmt::print(stderr, "arkmesh: warning: {}\n", doubt);
  return doubts.empty();
}

void import_ark(const CalibrateOptions& options) {
  const auto [width_m, height_m] = options.arena_sides_m();
  tracker::ArkArena arena;
  std::tie(arena.width_px, arena.height_px) = options.ark_picture_px();
  arena.overview_px = std::min(arena.width_px, arena.height_px);
  arena.arena_width_m = width_m;
  arena.arena_height_m = height_m;
  arena.camera_height_m = options.camera_height_m;
  std::vector<tracker::NamedCamera> cameras;
  for (const tracker::CameraData& data : tracker::import_ark_calibration(options.ark, arena)) {
    cameras.push_back({fmt::format("camera{}", cameras.size()), data, {}});
    const auto place = tracker::Calibration(data).position_m();
    const double robot_px = testbed::robot_width_px(data, {place[0], place[1]}).value_or(0);
    if (robot_px < 4 || robot_px > 500)
      throw std::runtime_error(
          fmt::format("in pictures of {} x {} pixels a robot below camera{} would be {:.1f} px wide; is --size the "
                      "size of its pictures?",
                      arena.width_px, arena.height_px, cameras.size() - 1, robot_px));
    fmt::print("camera{}: over {:.3f},{:.3f}{}\n", cameras.size() - 1, place[0], place[1],
               robot_width(data, {place[0], place[1]}));
  }
  tracker::write_calibrations(options.out, cameras);
  fmt::print("{}: {}\n", options.out, hal::counted(cameras.size(), "camera"));
}

}  // namespace

void add_calibrate_command(CLI::App* command) {
  const auto options = std::make_shared<CalibrateOptions>();
  command
      ->add_option("PICTURES", options->pictures,
                   "Pictures of a chessboard at different angles, together covering the camera's view")
      ->check(CLI::ExistingFile);
  command->add_option("--board", options->board, "Inner corners of the chessboard, columns x rows")
      ->capture_default_str();
  command->add_option("--square-mm", options->square_mm, "Side of one of its squares, in millimetres")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command->add_option("--arena", options->arena, "Width x height of the arena in metres, along x (east) and y (north)")
      ->capture_default_str();
  command->add_option("--corner", options->corners,
                      "A corner of the arena in pixels, x,y; four times, clockwise from the north-west corner");
  command
      ->add_option("--corners", options->corner_picture,
                   "A picture of the whole arena, in which arkmesh finds landmarks; with them a lab later detects that "
                   "the camera was moved. Without --corner and --landmark it also finds the corners; the upper left "
                   "one is the north-west corner")
      ->check(CLI::ExistingFile);
  command
      ->add_option(
          "--landmark", options->landmarks,
          "A point in the picture and in the arena: x,y=x,y in pixels and metres (x east, y north of the arena's "
          "centre); at least four, spread over the view, for a camera that does not see all four corners")
      ->excludes("--corner");
  command->add_option("--name", options->name, "The camera's name in the file")->capture_default_str();
  command->add_option("--png", options->png, "Draw the arena's outline over its picture, to check the calibration");
  command->add_option("--out", options->out, "The calibration file (.yaml); other cameras in it are kept")->required();
  command
      ->add_option("--intrinsics", options->intrinsics,
                   "A lens calibration from OpenCV or ROS (YAML), in place of PICTURES")
      ->check(CLI::ExistingFile);
  auto* ark =
      command->add_option("--import-ark", options->ark, "Convert an ARK calibration instead")->check(CLI::ExistingFile);
  command->add_option("--camera-height", options->camera_height_m, "Height of ARK's cameras above the arena, in metres")
      ->check(CLI::Range(0.1, 50.0))
      ->needs(ark)
      ->capture_default_str();
  command->add_option("--size", options->size, "Size of the pictures of ARK's cameras, width x height in pixels")
      ->needs(ark)
      ->capture_default_str();
  command->footer(
      "Examples:\n  arkmesh calibrate board*.png --board 7x6 --square-mm 25 --corners arena.png --arena 1x1 --out "
      "testbed.yaml\n"
      "  arkmesh calibrate --import-ark calibration.xml --arena 2x2 --out testbed.yaml\n"
      "Exit code 4: the file was written, but a number in it is uncertain; a warning names it.");
  command->callback([options] {
    tracker::quieten_libraries();
    if (!options->ark.empty())
      import_ark(*options);
    else
      end_with(calibrate(*options) ? 0 : uncertain_code);
  });
}

}  // namespace arkmesh::cli
