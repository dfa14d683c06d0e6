#include "tracker/camera/rectified_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace arkmesh::tracker {
namespace {

constexpr double round_enough = 1.12;  // longer axis of a robot's image by the shorter one
constexpr double max_pixels_part = 2;  // of the camera's own picture
constexpr int steps = 32;              // of the arena, each way

// The part of the arena that a camera sees, and how.
struct Overlook {
  double west = std::numeric_limits<double>::infinity(), east = -west, south = west, north = -west;  // metres
  double stretch = 1;   // longest axis of a robot's image by its shortest, where that is most
  double px_per_m = 0;  // mean over the places seen
  int places = 0;
};

Overlook look_over(const Calibration& camera, double board_m) {
  Overlook seen;
  const double width_m = camera.data().arena_width_m, height_m = camera.data().arena_height_m;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j) {
      const Point at{width_m * (static_cast<double>(i) / steps - 0.5),
                     height_m * (static_cast<double>(j) / steps - 0.5)};
      const auto pixel = camera.to_pixel(at, board_m);
      if (!pixel || camera.inside_px(*pixel) < 0) continue;
      const auto scale = camera.scale(at, board_m);
      if (!scale || !(scale->smallest > 0)) continue;
      seen.west = std::min(seen.west, at.x), seen.east = std::max(seen.east, at.x);
      seen.south = std::min(seen.south, at.y), seen.north = std::max(seen.north, at.y);
      seen.stretch = std::max(seen.stretch, scale->largest / scale->smallest);
      seen.px_per_m += (scale->largest + scale->smallest) / 2;
      ++seen.places;
    }
  if (seen.places) seen.px_per_m /= seen.places;
  return seen;
}

}  // namespace

std::optional<RectifiedView> RectifiedView::of(const Calibration& camera, double board_m) {
  Overlook seen = look_over(camera, board_m);
  if (seen.places < 4 || seen.stretch < round_enough) return {};
  const CameraData& real = camera.data();
  const auto& place = camera.position_m();
  // Half a step more on each side, since the grid's outermost places are not the view's edge.
  const double more_x = real.arena_width_m / steps, more_y = real.arena_height_m / steps;
  seen.west -= more_x, seen.east += more_x, seen.south -= more_y, seen.north += more_y;
  const double most = max_pixels_part * real.lens.width_px * real.lens.height_px;
  const double area_m2 = (seen.east - seen.west) * (seen.north - seen.south);
  const double px_per_m = std::min(seen.px_per_m, std::sqrt(most / area_m2)), down_m = place[2] - board_m;
  if (!(down_m > 0)) return {};

  CameraData data = real;
  const double focal_px = px_per_m * down_m;
  data.lens.model = LensModel::pinhole;
  data.lens.distortion.clear();
  data.lens.width_px = static_cast<int>((seen.east - seen.west) * px_per_m);
  data.lens.height_px = static_cast<int>((seen.north - seen.south) * px_per_m);
  data.lens.matrix = {
      focal_px, 0, (place[0] - seen.west) * px_per_m, 0, focal_px, (seen.north - place[1]) * px_per_m, 0, 0, 1};
  data.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  data.translation_m = {-place[0], place[1], place[2]};
  return RectifiedView(camera, Calibration(std::move(data)), board_m);
}

RectifiedView::RectifiedView(Calibration camera, Calibration straight, double board_m)
    : camera_(std::move(camera)), straight_(std::move(straight)), board_m_(board_m) {
  const int width_px = straight_.data().lens.width_px, height_px = straight_.data().lens.height_px;
  // Pixels that nobody sees are taken from far outside, where the border goes on.
  cv::Mat from(height_px, width_px, CV_32FC2, cv::Scalar::all(-1e4));
  for (int y = 0; y < height_px; ++y)
    for (int x = 0; x < width_px; ++x) {
      const auto place = straight_.to_arena({static_cast<double>(x), static_cast<double>(y)}, board_m_);
      const auto pixel = place ? camera_.to_pixel(*place, board_m_) : std::nullopt;
      if (pixel)
        from.at<cv::Vec2f>(y, x) = {static_cast<float>(std::clamp(pixel->x, -1e4, 3e4)),
                                    static_cast<float>(std::clamp(pixel->y, -1e4, 3e4))};
    }
  cv::convertMaps(from, cv::noArray(), places_, parts_, CV_16SC2);
}

const cv::Mat& RectifiedView::turn(const cv::Mat& picture) {
  cv::remap(picture, turned_, places_, parts_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return turned_;
}

std::vector<Detection> RectifiedView::in_camera(std::span<const Detection> detections) const {
  std::vector<Detection> out;
  for (const Detection& found : detections) {
    const auto place = straight_.to_arena({found.x_px, found.y_px}, board_m_);
    const auto pixel = place ? camera_.to_pixel(*place, board_m_) : std::nullopt;
    const auto scale = place ? camera_.scale(*place, board_m_) : std::nullopt,
               straight = place ? straight_.scale(*place, board_m_) : std::nullopt;
    if (!pixel || !scale || !straight) continue;
    Detection one = found;
    one.x_px = pixel->x, one.y_px = pixel->y;
    one.r_px = found.r_px * (scale->largest + scale->smallest) / (straight->largest + straight->smallest);
    if (camera_.inside_px(*pixel) < 0.9 * one.r_px) continue;
    if (std::isfinite(found.led_x_px) && std::isfinite(found.led_y_px)) {
      const auto led_place = straight_.to_arena({found.led_x_px, found.led_y_px}, board_m_);
      const auto led = led_place ? camera_.to_pixel(*led_place, board_m_) : std::nullopt;
      if (!led) continue;
      one.led_x_px = led->x, one.led_y_px = led->y;
    }
    out.push_back(one);
  }
  return out;
}

}  // namespace arkmesh::tracker
