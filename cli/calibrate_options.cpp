#include "cli/calibrate_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "cli/two_numbers.hpp"

namespace arkmesh::cli {
namespace {

// Two numbers above or at 0.
std::pair<double, double> numbers_of(const std::string& text, char between, const std::string& option,
                                     const std::string& example) {
  const auto numbers = two_numbers(text, between);
  if (!numbers || !(numbers->first >= 0) || !(numbers->second >= 0))
    throw CLI::ValidationError(option, fmt::format("{} is not of the form {}", text, example));
  return *numbers;
}

}  // namespace

std::pair<double, double> sides_of(const CalibrateOptions& options) {
  const auto sides = numbers_of(options.arena, 'x', "--arena", "1x1 (metres)");
  if (!(sides.first > 0 && sides.second > 0 && sides.first <= 100 && sides.second <= 100))
    throw CLI::ValidationError("--arena", "the sides must be above 0 and at most 100 m");
  return sides;
}

std::pair<int, int> picture_size_of(const CalibrateOptions& options) {
  const auto [width_px, height_px] = numbers_of(options.size, 'x', "--size", "2048x1536 (pixels)");
  if (width_px < 1 || height_px < 1 || width_px > 100'000 || height_px > 100'000)
    throw CLI::ValidationError("--size", "that is no camera's picture");
  return {static_cast<int>(width_px), static_cast<int>(height_px)};
}

tracker::ChessboardSize board_of(const CalibrateOptions& options) {
  const auto [columns, rows] = numbers_of(options.board, 'x', "--board", "7x6 (inner corners)");
  if (columns < 3 || rows < 3 || columns > 50 || rows > 50 || columns != static_cast<int>(columns) ||
      rows != static_cast<int>(rows))
    throw CLI::ValidationError("--board", "a chessboard has 3 to 50 inner corners along each side");
  return {static_cast<int>(columns), static_cast<int>(rows), options.square_mm};
}

std::vector<tracker::Point> given_corners(const CalibrateOptions& options) {
  std::vector<tracker::Point> corners;
  for (const std::string& text : options.corners) {
    const auto [x, y] = numbers_of(text, ',', "--corner", "120.5,33 (pixels)");
    corners.push_back({x, y});
  }
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

}  // namespace arkmesh::cli
