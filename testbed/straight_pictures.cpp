#include "testbed/straight_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>

#include "hal/platforms/kilobot/body.hpp"

namespace arkmesh::testbed {
namespace {

constexpr int picture_quality = 75, picture_px = 960;
constexpr double beside_arena_m = 0.1;
constexpr int looks = 40;  // in each direction, for what a camera sees
// So much longer than a picture takes is the time until the next.
constexpr int rest_factor = 30;
constexpr std::chrono::milliseconds least_gap{66};

std::array<double, 12> pose_of(const tracker::Calibration& camera) {
  std::array<double, 12> out;
  const auto rest = std::ranges::copy(camera.data().rotation, out.begin()).out;
  std::ranges::copy(camera.data().translation_m, rest);
  return out;
}

}  // namespace

std::optional<StraightView> StraightView::of(const tracker::Calibration& camera, double board_m, int largest_px) {
  const double half_x = camera.data().arena_width_m / 2 + beside_arena_m,
               half_y = camera.data().arena_height_m / 2 + beside_arena_m;
  double west = half_x, east = -half_x, south = half_y, north = -half_y, finest = 0;
  for (int i = 0; i <= looks; ++i)
    for (int j = 0; j <= looks; ++j) {
      const tracker::Point at{half_x * (2.0 * i / looks - 1), half_y * (2.0 * j / looks - 1)};
      const auto pixel = camera.to_pixel(at, board_m);
      if (!pixel || camera.inside_px(*pixel) < 0) continue;
      west = std::min(west, at.x), east = std::max(east, at.x);
      south = std::min(south, at.y), north = std::max(north, at.y);
      if (const auto scale = camera.scale(at, board_m)) finest = std::max(finest, scale->largest);
    }
  if (west >= east || south >= north) return std::nullopt;
  const double px_per_m = std::min(finest, largest_px / std::max(east - west, north - south));
  StraightView out;
  out.frame_.width_px = std::max(1, static_cast<int>((east - west) * px_per_m));
  out.frame_.height_px = std::max(1, static_cast<int>((north - south) * px_per_m));
  out.frame_.arena_to_px = {px_per_m, 0, -west * px_per_m, 0, -px_per_m, north * px_per_m, 0, 0, 1};
  out.pose_ = pose_of(camera);
  cv::Mat from(out.frame_.height_px, out.frame_.width_px, CV_32FC2, cv::Scalar::all(-1e4));
  for (int y = 0; y < from.rows; ++y)
    for (int x = 0; x < from.cols; ++x)
      if (const auto pixel = camera.to_pixel({west + (x + 0.5) / px_per_m, north - (y + 0.5) / px_per_m}, board_m))
        from.at<cv::Vec2f>(y, x) = {static_cast<float>(pixel->x), static_cast<float>(pixel->y)};
  cv::convertMaps(from, cv::noArray(), out.places_, out.parts_, CV_16SC2);
  return out;
}

cv::Mat StraightView::turn(const cv::Mat& picture) const {
  cv::Mat out;
  cv::remap(picture, out, places_, parts_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return out;
}

bool StraightView::is_of(const tracker::Calibration& camera) const {
  return pose_ == pose_of(camera);
}

void StraightPictures::look(const Look& look) {
  hal::PictureWatcher* const watcher = board_.watcher();
  if (!watcher) return;
  for (std::size_t k = 0; k < look.pictures.size(); ++k) {
    const auto before = Monotonic::now();
    if (look.pictures[k].empty() || before < next_[k]) continue;
    show(*watcher, k, look.pictures[k], look);
    const auto after = Monotonic::now();
    next_[k] = std::max(before + least_gap, after + rest_factor * (after - before));
  }
}

void StraightPictures::show(hal::PictureWatcher& watcher, std::size_t camera, const cv::Mat& picture,
                            const Look& look) {
  const tracker::Calibration* const lies = look.tracker.calibration(camera);
  if (!lies) return;
  const std::string name = fmt::format("camera{}", camera);
  const auto made = views_.find(camera);
  // Anew when the camera was moved and its calibration has followed.
  if (made == views_.end() || (made->second && !made->second->is_of(*lies))) {
    views_[camera] = StraightView::of(*lies, hal::kilobot::board_height_m, picture_px);
    if (views_[camera]) {
      hal::PictureFrame frame = views_[camera]->frame();
      frame.camera = name;
      watcher.set_frame(frame);
    }
  }
  const auto& view = views_[camera];
  if (!view) return;
  std::vector<unsigned char> jpeg;
  if (cv::imencode(".jpg", view->turn(picture), jpeg, {cv::IMWRITE_JPEG_QUALITY, picture_quality}))
    watcher.show_picture(name, look.now, std::as_bytes(std::span(jpeg)));
}

}  // namespace arkmesh::testbed
