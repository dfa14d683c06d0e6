#include "cli/calibrate_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace arkmesh::cli {
namespace {

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

}  // namespace

void CalibrateOptions::add_to(CLI::App& command) {
  command.add_option("PICTURES", pictures, "Pictures of a chessboard, at different slants, all over the camera's view")
      ->check(CLI::ExistingFile);
  command.add_option("--board", board, "Inner corners of the chessboard, columns x rows")->capture_default_str();
  command.add_option("--square-mm", square_mm, "Side of one of its squares, in millimetres")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command.add_option("--arena", arena, "Width x height of the arena in metres, along x (east) and y (north)")
      ->capture_default_str();
  command.add_option("--corner", corners,
                     "A corner of the arena in pixels, x,y; four times, from the north-west one clockwise");
  command
      .add_option("--corners", corner_picture,
                  "A picture of the whole arena, in which arkmesh finds the landmarks by which a lab notices that the "
                  "camera was moved since; without --corner and --landmark also the corners, of which it takes the "
                  "upper left one for the north-west one")
      ->check(CLI::ExistingFile);
  command
      .add_option("--landmark", landmarks,
                  "A point of the arena, in the picture and in the arena: x,y=x,y in pixels and metres (x "
                  "east, y north of the "
                  "arena's middle); "
                  "four times or more, spread over the view, for a camera that does not see all four corners")
      ->excludes("--corner");
  command.add_option("--name", name, "The camera's name in the file")->capture_default_str();
  command.add_option("--png", png, "Draw the arena's outline over its picture, to check the calibration");
  command.add_option("--out", out, "The calibration file (.yaml); other cameras in it are kept")->required();
  auto* import_ark =
      command.add_option("--import-ark", ark, "Convert an ARK calibration instead")->check(CLI::ExistingFile);
  command.add_option("--camera-height", camera_height_m, "Height of ARK's cameras above the arena, in metres")
      ->check(CLI::Range(0.1, 50.0))
      ->needs(import_ark)
      ->capture_default_str();
  command.add_option("--size", size, "Size of the pictures of ARK's cameras, width x height in pixels")
      ->needs(import_ark)
      ->capture_default_str();
}

std::pair<double, double> CalibrateOptions::arena_sides_m() const {
  const auto sides = two_numbers(arena, 'x', "--arena", "1x1 (metres)");
  if (!(sides.first > 0 && sides.second > 0 && sides.first <= 100 && sides.second <= 100))
    throw CLI::ValidationError("--arena", "the sides must be above 0 and at most 100 m");
  return sides;
}

tracker::ChessboardSize CalibrateOptions::chessboard() const {
  const auto [columns, rows] = two_numbers(board, 'x', "--board", "7x6 (inner corners)");
  if (columns < 3 || rows < 3 || columns > 50 || rows > 50 || columns != static_cast<int>(columns) ||
      rows != static_cast<int>(rows))
    throw CLI::ValidationError("--board", "a chessboard has 3 to 50 inner corners along each side");
  return {static_cast<int>(columns), static_cast<int>(rows), square_mm};
}

std::pair<int, int> CalibrateOptions::ark_picture_px() const {
  const auto [width_px, height_px] = two_numbers(size, 'x', "--size", "2048x1536 (pixels)");
  if (width_px < 1 || height_px < 1 || width_px > 100'000 || height_px > 100'000)
    throw CLI::ValidationError("--size", "no camera has pictures of this size");
  return {static_cast<int>(width_px), static_cast<int>(height_px)};
}

std::vector<tracker::Point> CalibrateOptions::given_corners() const {
  std::vector<tracker::Point> found;
  for (const std::string& text : corners) {
    const auto [x, y] = two_numbers(text, ',', "--corner", "120.5,33 (pixels)");
    found.push_back({x, y});
  }
  return found;
}

// "812.5,64=-0.25,0.5": pixels, and metres of the arena frame.
std::vector<tracker::Mark> CalibrateOptions::given_landmarks() const {
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

}  // namespace arkmesh::cli
