// `arkmesh calibrate`: pictures of a chessboard and of the arena's corners in, a calibration file out, with its error
// in millimetres.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "tracker/calibration_file.hpp"
#include "tracker/camera_fit.hpp"
#include "tracker/source.hpp"
#include "tracker/table_corners.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

struct CalibrateOptions {
  std::vector<std::string> pictures, corners, marks;
  std::string board = "7x6", arena = "1x1", corner_picture, out, name = "camera0", png, ark, size = "2048x1536";
  double square_mm = 25, camera_height_m = 1.6;
};

// "7x6" or "120.5,33": two numbers above or at 0 and nothing else.
std::pair<double, double> two_numbers(const std::string& text, char between, const std::string& option,
                                      const std::string& example) {
  double first = 0, second = 0;
  char separator = 0, rest = 0;
  if (std::sscanf(text.c_str(), "%lf%c%lf%c", &first, &separator, &second, &rest) != 3 || separator != between ||
      !(first >= 0) || !(second >= 0))
    throw CLI::ValidationError(option, fmt::format("{} is not of the form {}", text, example));
  return {first, second};
}

std::pair<double, double> sides_of(const CalibrateOptions& options) {
  const auto sides = two_numbers(options.arena, 'x', "--arena", "1x1 (metres)");
  if (!(sides.first > 0 && sides.second > 0 && sides.first <= 100 && sides.second <= 100))
    throw CLI::ValidationError("--arena", "the sides must be above 0 and at most 100 m");
  return sides;
}

cv::Mat read_picture(const std::string& file) {
  cv::Mat picture = tracker::read_picture(file);
  if (picture.empty()) throw std::runtime_error(fmt::format("{} is damaged or no picture", file));
  return picture;
}

tracker::FittedLens fit_lens(const CalibrateOptions& options) {
  const auto [columns, rows] = two_numbers(options.board, 'x', "--board", "7x6 (inner corners)");
  if (columns < 3 || rows < 3 || columns > 50 || rows > 50 || columns != static_cast<int>(columns) ||
      rows != static_cast<int>(rows))
    throw CLI::ValidationError("--board", "a chessboard has 3 to 50 inner corners along each side");
  tracker::LensFit fit({static_cast<int>(columns), static_cast<int>(rows), options.square_mm});
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

std::vector<tracker::Point> corners_of(const CalibrateOptions& options, const tracker::Lens& lens) {
  std::vector<tracker::Point> corners;
  for (const std::string& text : options.corners) {
    const auto [x, y] = two_numbers(text, ',', "--corner", "120.5,33 (pixels)");
    corners.push_back({x, y});
  }
  if (!corners.empty()) return corners;
  if (options.corner_picture.empty())
    throw CLI::ValidationError("--corner",
                               "give the arena's corners: four times --corner x,y, or a picture with --corners");
  const cv::Mat picture = read_picture(options.corner_picture);
  if (picture.cols != lens.width_px || picture.rows != lens.height_px)
    throw std::runtime_error(
        fmt::format("{} is {} x {} pixels, the chessboard pictures are {} x {}; use one camera at one resolution",
                    options.corner_picture, picture.cols, picture.rows, lens.width_px, lens.height_px));
  corners = tracker::find_table_corners(picture);
  if (corners.empty())
    throw std::runtime_error(
        fmt::format("{}: no table stands out from its surroundings; give its corners with --corner x,y, four times",
                    options.corner_picture));
  for (const tracker::Point& at : corners) fmt::print("corner {:.1f},{:.1f}\n", at.x, at.y);
  return corners;
}

// "812.5,64=-0.25,0.5": pixels, and metres of the arena frame.
std::vector<tracker::Mark> marks_of(const CalibrateOptions& options) {
  std::vector<tracker::Mark> marks;
  for (const std::string& text : options.marks) {
    tracker::Mark mark;
    char rest = 0;
    const int read = std::sscanf(text.c_str(), "%lf,%lf=%lf,%lf%c", &mark.in_pixels.x, &mark.in_pixels.y,
                                 &mark.in_arena.x, &mark.in_arena.y, &rest);
    const double numbers[] = {mark.in_pixels.x, mark.in_pixels.y, mark.in_arena.x, mark.in_arena.y};
    if (read != 4 ||
        !std::all_of(std::begin(numbers), std::end(numbers), [](double number) { return std::abs(number) < 1e5; }))
      throw CLI::ValidationError(
          "--mark", fmt::format("{} is not of the form 812.5,64=-0.25,0.5 (pixels=metres of the arena frame)", text));
    marks.push_back(mark);
  }
  return marks;
}

// The arena's outline and a grid of tenths over the picture, so that one sees whether it lies on the table.
void draw_check(const CalibrateOptions& options, const tracker::CameraData& data) {
  if (options.png.empty()) return;
  cv::Mat picture = options.corner_picture.empty()
                        ? cv::Mat(data.lens.height_px, data.lens.width_px, CV_8UC3, cv::Scalar::all(60))
                        : read_picture(options.corner_picture);
  const tracker::Calibration camera(data);
  const auto draw = [&](tracker::Point from, tracker::Point to, const cv::Scalar& colour, int thick) {
    constexpr int steps = 40;
    std::optional<tracker::Point> before;
    for (int i = 0; i <= steps; ++i) {
      const auto at = camera.to_pixel({from.x + (to.x - from.x) * i / steps, from.y + (to.y - from.y) * i / steps}, 0);
      if (at && before)
        cv::line(picture, cv::Point2d(before->x, before->y), cv::Point2d(at->x, at->y), colour, thick, cv::LINE_AA);
      before = at;
    }
  };
  const double east = data.arena_width_m / 2, north = data.arena_height_m / 2;
  for (int i = 0; i <= 10; ++i) {
    const bool edge = i == 0 || i == 10;
    const cv::Scalar colour = edge ? cv::Scalar(0, 0, 255) : cv::Scalar(0, 200, 200);
    const double x = -east + 2 * east * i / 10, y = -north + 2 * north * i / 10;
    draw({x, -north}, {x, north}, colour, edge ? 2 : 1);
    draw({-east, y}, {east, y}, colour, edge ? 2 : 1);
  }
  bool written = false;
  try {
    written = cv::imwrite(options.png, picture);
  } catch (const cv::Exception&) {
    // Said below.
  }
  if (!written)
    throw std::runtime_error(
        fmt::format("{} cannot be written: give a name ending in .png in a folder that exists", options.png));
}

// Whether robots are large enough in the picture is what people can still change.
std::string robot_width(const tracker::CameraData& data, tracker::Point at) {
  const auto scale = tracker::Calibration(data).scale(at, tracker::board_height_m);
  if (!scale) return "";
  const double width_px = (scale->largest + scale->smallest) / 2 * 2 * hal::kilobot::body_radius_m;
  return fmt::format(": a robot there is {:.1f} px wide{}", width_px,
                     width_px < 12 ? ", too few: bring the camera nearer, or take more pixels" : "");
}

// Adds the camera to those of the file, or takes the place of its namesake.
void write_into(const CalibrateOptions& options, const tracker::CameraData& data) {
  std::vector<tracker::NamedCamera> cameras;
  if (fs::exists(options.out)) cameras = tracker::read_calibrations(options.out);
  const auto same =
      std::find_if(cameras.begin(), cameras.end(), [&](const auto& camera) { return camera.name == options.name; });
  if (same != cameras.end())
    same->data = data;
  else
    cameras.push_back({options.name, data});
  tracker::write_calibrations(options.out, cameras);
  fmt::print("{}: {} camera{} ({})\n", options.out, cameras.size(), cameras.size() == 1 ? "" : "s", options.name);
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
  draw_check(options, data);
  write_into(options, data);
}

void import_ark(const CalibrateOptions& options) {
  const auto [width_m, height_m] = sides_of(options);
  const auto [width_px, height_px] = two_numbers(options.size, 'x', "--size", "2048x1536 (pixels)");
  if (width_px < 1 || height_px < 1 || width_px > 100'000 || height_px > 100'000)
    throw CLI::ValidationError("--size", "that is no camera's picture");
  tracker::ArkTable table;
  table.width_px = static_cast<int>(width_px);
  table.height_px = static_cast<int>(height_px);
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
  auto* command = app.add_subcommand(
      "calibrate", "Makes a camera's calibration from pictures of a chessboard and of the arena's corners");
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
