#include "testbed/camera_calibration.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "hal/platforms/kilobot/body.hpp"
#include "testbed/kilobot_tracking.hpp"

namespace arkmesh::testbed {

void draw_arena(cv::Mat& picture, const tracker::CameraData& camera) {
  const tracker::Calibration calibration(camera);
  const auto draw = [&](tracker::Point from, tracker::Point to, const cv::Scalar& colour, int thick) {
    constexpr int steps = 40;
    std::optional<tracker::Point> before;
    for (int i = 0; i <= steps; ++i) {
      const auto at =
          calibration.to_pixel({from.x + (to.x - from.x) * i / steps, from.y + (to.y - from.y) * i / steps}, 0);
      if (at && before)
        cv::line(picture, cv::Point2d(before->x, before->y), cv::Point2d(at->x, at->y), colour, thick, cv::LINE_AA);
      before = at;
    }
  };
  const double east = camera.arena_width_m / 2, north = camera.arena_height_m / 2;
  for (int i = 0; i <= 10; ++i) {
    const bool edge = i == 0 || i == 10;
    const cv::Scalar colour = edge ? cv::Scalar(0, 0, 255) : cv::Scalar(0, 200, 200);
    const double x = -east + 2 * east * i / 10, y = -north + 2 * north * i / 10;
    draw({x, -north}, {x, north}, colour, edge ? 2 : 1);
    draw({-east, y}, {east, y}, colour, edge ? 2 : 1);
  }
}

std::optional<double> robot_width_px(const tracker::CameraData& camera, tracker::Point at) {
  const auto scale = tracker::Calibration(camera).scale(at, hal::kilobot::board_height_m);
  if (!scale) return {};
  return (scale->largest + scale->smallest) / 2 * 2 * hal::kilobot::body_radius_m;
}

std::vector<tracker::Landmark> landmarks_of(const cv::Mat& picture, const tracker::CameraData& camera) {
  const tracker::Calibration calibration(camera);
  tracker::ArenaTracker robots({calibration}, kilobot_tracking());
  robots.look(hal::LabTime{0}, {&picture, 1});
  return tracker::find_landmarks(picture, robots.detections(0), calibration);
}

std::size_t put_into(const std::filesystem::path& file, const tracker::NamedCamera& camera) {
  std::vector<tracker::NamedCamera> cameras;
  if (std::filesystem::exists(file)) cameras = tracker::read_calibrations(file);
  const auto same = std::ranges::find(cameras, camera.name, &tracker::NamedCamera::name);
  if (same != cameras.end())
    *same = camera;
  else
    cameras.push_back(camera);
  tracker::write_calibrations(file, cameras);
  return cameras.size();
}

}  // namespace arkmesh::testbed
