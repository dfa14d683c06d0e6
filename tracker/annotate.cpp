#include "tracker/annotate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tracker/brush.hpp"

namespace arkmesh::tracker {
namespace {

constexpr double known_heading_rad = 1.0;  // an arrow is drawn when the heading is surer than that
cv::Scalar colour_of(hal::Led led, const cv::Scalar& off) {
  const int bits = static_cast<int>(led);
  if (led == hal::Led::unknown) return cv::Scalar::all(150);
  return led == hal::Led::off ? off : cv::Scalar(bits & 4 ? 255 : 0, bits & 2 ? 255 : 0, bits & 1 ? 255 : 0);
}

}  // namespace

void draw_tracks(cv::Mat& picture, const Calibration& camera, std::span<const Track> tracks, const Body& body) {
  for (const Track& track : tracks) {
    const Point centre{track.in_arena.x_m, track.in_arena.y_m};
    const auto middle = camera.to_pixel(centre, body.board_m);
    const std::vector<cv::Point> circle = ring(camera, centre, body.diameter_m / 2, body.board_m);
    if (!middle || circle.empty()) continue;
    const auto scale = camera.scale(centre, body.board_m);
    const double r_px = scale ? scale->largest * body.diameter_m / 2 : 0;
    if (camera.inside_px(*middle) < -r_px) continue;
    const cv::Scalar colour = colour_of(track.led, cv::Scalar(0, 140, 255));
    const bool seen = track.age.count() == 0;
    const int thick = seen ? std::max(1, static_cast<int>(r_px / 10)) : 1;
    cv::polylines(picture, circle, true, colour, thick, cv::LINE_AA, fine_shift);
    if (track.heading_sigma_rad < known_heading_rad) {
      const double heading = track.in_arena.heading_rad, length_m = 0.75 * body.diameter_m;
      const auto tip = fine(camera.to_pixel(
          {centre.x + length_m * std::cos(heading), centre.y + length_m * std::sin(heading)}, body.board_m));
      if (const auto from = fine(middle); tip && from)
        cv::line(picture, *from, *tip, colour, thick, cv::LINE_AA, fine_shift);
    }
    const std::string name =
        track.robot ? fmt::format("{}{}", *track.robot, track.doubtful ? "?" : "") : fmt::format("#{}", track.number);
    const cv::Scalar ink = track.doubtful ? cv::Scalar(80, 80, 255) : cv::Scalar::all(255);
    write(picture, name, {middle->x + 0.8 * r_px, middle->y - 0.8 * r_px}, r_px, ink);
  }
}

void draw_ghosts(cv::Mat& picture, const Calibration& camera, std::span<const hal::Observation> robots,
                 double radius_m) {
  for (const hal::Observation& robot : robots) {
    const std::vector<cv::Point> circle = ring(camera, {robot.pose.x_m, robot.pose.y_m}, radius_m, 0);
    if (!circle.empty())
      cv::polylines(picture, circle, true, colour_of(robot.led, cv::Scalar::all(150)), 2, cv::LINE_AA, fine_shift);
  }
}

void draw_border(cv::Mat& picture, const Calibration& camera) {
  const double east = camera.data().arena_width_m / 2, north = camera.data().arena_height_m / 2;
  const Point corners[] = {{-east, north}, {east, north}, {east, -north}, {-east, -north}};
  constexpr int steps = 32;  // of each side: lenses bend them
  std::optional<cv::Point> before;
  for (int i = 0; i <= 4 * steps; ++i) {
    const Point from = corners[i / steps % 4], to = corners[(i / steps + 1) % 4];
    const double along = i % steps / static_cast<double>(steps);
    const auto at = fine(camera.to_pixel({from.x + (to.x - from.x) * along, from.y + (to.y - from.y) * along}, 0));
    if (at && before) cv::line(picture, *before, *at, cv::Scalar(200, 200, 0), 1, cv::LINE_AA, fine_shift);
    before = at;
  }
}

void draw_caption(cv::Mat& picture, const std::string& text) {
  const double size_px = std::clamp(picture.rows / 24.0, 14.0, 32.0);
  write(picture, text, {size_px / 2, 1.2 * size_px}, size_px, cv::Scalar::all(255));
}

}  // namespace arkmesh::tracker
