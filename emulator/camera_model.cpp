#include "emulator/camera_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace arkmesh::emulator {
namespace {

cv::Matx33d rotation_of(const CameraPose& pose) {
  const cv::Vec3d sight(pose.look_x_m - pose.x_m, pose.look_y_m - pose.y_m, -pose.z_m);
  if (pose.z_m <= 0) throw std::invalid_argument("must hang above the arena");
  const cv::Vec3d ahead = sight / cv::norm(sight), north(0, 1, 0);
  cv::Vec3d right = ahead.cross(north);
  if (cv::norm(right) < 1e-6) throw std::invalid_argument("looks along the arena's north; point it down");
  right /= cv::norm(right);
  const cv::Vec3d down = ahead.cross(right);
  const double c = std::cos(pose.roll_rad), s = std::sin(pose.roll_rad);
  const cv::Vec3d x = c * right + s * down, y = c * down - s * right;
  return {x[0], x[1], x[2], y[0], y[1], y[2], ahead[0], ahead[1], ahead[2]};
}

cv::Vec3d translation_of(const cv::Matx33d& rotation, const CameraPose& pose) {
  return -(rotation * cv::Vec3d(pose.x_m, pose.y_m, pose.z_m));
}

}  // namespace

CameraModel::CameraModel(int width_px, int height_px, double focal_px, double centre_x_px, double centre_y_px,
                         const std::array<double, 5>& distortion, const CameraPose& pose)
    : width_px_(width_px),
      height_px_(height_px),
      matrix_(focal_px, 0, centre_x_px, 0, focal_px, centre_y_px, 0, 0, 1),
      rotation_(rotation_of(pose)),
      translation_(translation_of(rotation_, pose)),
      distortion_(distortion) {
  // outwards until the distorted radius no longer grows
  constexpr double step = 0.001, farthest = 3;
  double before = 0, radius = 0;
  for (double r = step; r < farthest; r += step) {
    const double r2 = r * r, out = r * (1 + r2 * (distortion[0] + r2 * (distortion[1] + r2 * distortion[4])));
    if (out <= before) break;
    before = out;
    radius = r;
  }
  max_radius2_ = radius * radius;
  const double corner =
      std::hypot(std::max(centre_x_px, width_px - centre_x_px), std::max(centre_y_px, height_px - centre_y_px)) /
      focal_px;
  if (corner > farthest)
    throw std::invalid_argument("sees more than 71 degrees to the side; give it a longer focal_px");
  if (before < corner)
    throw std::invalid_argument("has a distortion that folds the image inside its corners; use smaller coefficients");
}

double CameraModel::focal_to_fit(int width_px, int height_px, const CameraPose& pose,
                                 const std::vector<cv::Point2d>& corners, double margin) {
  const cv::Matx33d rotation = rotation_of(pose);
  const cv::Vec3d translation = translation_of(rotation, pose);
  double most = 1e-6;
  for (const cv::Point2d& corner : corners) {
    const cv::Vec3d at = rotation * cv::Vec3d(corner.x, corner.y, 0) + translation;
    if (at[2] <= 0.01) throw std::invalid_argument("does not see the whole arena; mount it higher or set focal_px");
    most = std::max({most, std::abs(at[0] / at[2]) / width_px, std::abs(at[1] / at[2]) / height_px});
  }
  return (0.5 - margin) / most;
}

cv::Point2d CameraModel::distort(double x, double y) const {
  const auto& [k1, k2, p1, p2, k3] = distortion_;
  const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

std::optional<cv::Point2d> CameraModel::project(double x_m, double y_m, double z_m) const {
  const cv::Vec3d at = rotation_ * cv::Vec3d(x_m, y_m, z_m) + translation_;
  if (!(at[2] > 1e-3)) return std::nullopt;
  const double x = at[0] / at[2], y = at[1] / at[2];
  if (!(x * x + y * y < max_radius2_)) return std::nullopt;
  const cv::Point2d out = distort(x, y);
  return cv::Point2d(matrix_(0, 0) * out.x + matrix_(0, 2), matrix_(1, 1) * out.y + matrix_(1, 2));
}

std::optional<LocalMap> CameraModel::project_near(double x_m, double y_m, double z_m) const {
  constexpr double step_m = 0.005;
  const auto at = project(x_m, y_m, z_m), east = project(x_m + step_m, y_m, z_m),
             west = project(x_m - step_m, y_m, z_m), north = project(x_m, y_m + step_m, z_m),
             south = project(x_m, y_m - step_m, z_m);
  if (!at || !east || !west || !north || !south) return std::nullopt;
  constexpr double per_m = 1 / (2 * step_m);
  return LocalMap{at->x,
                  at->y,
                  (east->x - west->x) * per_m,
                  (north->x - south->x) * per_m,
                  (east->y - west->y) * per_m,
                  (north->y - south->y) * per_m};
}

// Newton steps on the distortion.
cv::Point2d CameraModel::ideal(cv::Point2d pixel) const {
  const double to_x = (pixel.x - matrix_(0, 2)) / matrix_(0, 0), to_y = (pixel.y - matrix_(1, 2)) / matrix_(1, 1);
  double x = to_x, y = to_y;
  if (const double most = std::sqrt(max_radius2_), r = std::hypot(x, y); r > 0.99 * most) {
    x *= 0.99 * most / r;
    y *= 0.99 * most / r;
  }
  for (int k = 0; k < 20; ++k) {
    const cv::Point2d now = distort(x, y);
    const double ex = now.x - to_x, ey = now.y - to_y;
    if (ex * ex + ey * ey < 1e-20) break;
    constexpr double h = 1e-6;
    const cv::Point2d along_x = (distort(x + h, y) - now) / h, along_y = (distort(x, y + h) - now) / h;
    const double det = along_x.x * along_y.y - along_y.x * along_x.y;
    if (std::abs(det) < 1e-9) break;
    x -= (ex * along_y.y - ey * along_y.x) / det;
    y -= (ey * along_x.x - ex * along_x.y) / det;
  }
  return {x, y};
}

std::optional<cv::Point2d> CameraModel::meets_plane(cv::Point2d ideal, double z_m) const {
  const cv::Vec3d sight = rotation_.t() * cv::Vec3d(ideal.x, ideal.y, 1), from = position();
  if (sight[2] >= -1e-9) return std::nullopt;
  const double way = (z_m - from[2]) / sight[2];
  return cv::Point2d(from[0] + way * sight[0], from[1] + way * sight[1]);
}

}  // namespace arkmesh::emulator
