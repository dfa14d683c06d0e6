#include "tracker/camera/calibration.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace arkmesh::tracker {
namespace {

using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Map<const RowMatrix> as_matrix(const Matrix3& m) {
  return Eigen::Map<const RowMatrix>(m.data());
}
Eigen::Map<const Eigen::Vector3d> as_vector(const std::array<double, 3>& v) {
  return Eigen::Map<const Eigen::Vector3d>(v.data());
}

constexpr double farthest_radius = 4;    // tan of 76 degrees: pinhole cameras do not see farther out
constexpr double farthest_angle = 1.55;  // just below the horizon

bool all_finite(const CameraData& data) {
  const auto finite = [](double v) { return std::isfinite(v); };
  return std::all_of(data.lens.matrix.begin(), data.lens.matrix.end(), finite) &&
         std::all_of(data.lens.distortion.begin(), data.lens.distortion.end(), finite) &&
         std::all_of(data.rotation.begin(), data.rotation.end(), finite) &&
         std::all_of(data.translation_m.begin(), data.translation_m.end(), finite);
}

void refuse_impossible(const CameraData& data) {
  const Lens& lens = data.lens;
  const std::size_t n = lens.distortion.size();
  if (!all_finite(data)) throw std::invalid_argument("a number is infinite or not a number");
  if (lens.width_px < 1 || lens.height_px < 1 || lens.width_px > 100'000 || lens.height_px > 100'000)
    throw std::invalid_argument(
        fmt::format("the picture size {} x {} is not that of a camera", lens.width_px, lens.height_px));
  if (lens.model == LensModel::fisheye ? n != 4 : n != 0 && n != 4 && n != 5 && n != 8)
    throw std::invalid_argument(
        fmt::format("{} distortion coefficients cannot be: a fisheye has 4, a pinhole 0, 4, 5 or 8", n));
  const Matrix3& k = lens.matrix;
  if (k[0] <= 0 || k[4] <= 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw std::invalid_argument(
        "the camera matrix is not of the form fx s cx / 0 fy cy / 0 0 1 with fx and fy above 0");
  const auto rotation = as_matrix(data.rotation);
  if (!(rotation * rotation.transpose()).isIdentity(1e-3) || rotation.determinant() < 0)
    throw std::invalid_argument("the rotation is not a rotation matrix");
  if (!(data.arena_width_m > 0 && data.arena_height_m > 0 && data.arena_width_m <= 100 && data.arena_height_m <= 100))
    throw std::invalid_argument("the arena's sides must be above 0 and at most 100 m");
}

}  // namespace

Calibration::Calibration(CameraData data) : data_(std::move(data)) {
  refuse_impossible(data_);
  Eigen::Map<RowMatrix>(inverse_matrix_.data()) = as_matrix(data_.lens.matrix).inverse();
  Eigen::Map<Eigen::Vector3d>(position_m_.data()) =
      -as_matrix(data_.rotation).transpose() * as_vector(data_.translation_m);
  if (!(position_m_[2] > 0)) throw std::invalid_argument("the camera is below the arena");
  // Outwards until the distorted radius no longer grows: beyond, two points of the arena would share a pixel.
  const double farthest = data_.lens.model == LensModel::fisheye ? farthest_angle : farthest_radius;
  constexpr int steps = 2000;
  double before = 0;
  for (int i = 1; i <= steps; ++i) {
    const double r = farthest * i / steps, out = radial(r);
    if (!(out > before)) break;
    before = out;
    reach_ = r;
  }
  if (reach_ < farthest / 100)
    throw std::invalid_argument("the distortion folds the whole picture; are coefficients in the wrong order?");
}

Calibration Calibration::overhead(int width_px, int height_px, double metres_per_px) {
  constexpr double far_m = 1e6;
  CameraData data;
  data.lens.width_px = width_px;
  data.lens.height_px = height_px;
  data.lens.matrix = {
      far_m / metres_per_px, 0, (width_px - 1) / 2.0, 0, far_m / metres_per_px, (height_px - 1) / 2.0, 0, 0, 1};
  data.translation_m = {0, 0, far_m};
  data.arena_width_m = std::min(100.0, width_px * metres_per_px);
  data.arena_height_m = std::min(100.0, height_px * metres_per_px);
  return Calibration(std::move(data));
}

// Distorted radius of an ideal radius (pinhole) or of an angle from the optical axis (fisheye).
double Calibration::radial(double r) const {
  const auto& d = data_.lens.distortion;
  const double r2 = r * r;
  if (data_.lens.model == LensModel::fisheye) return r * (1 + r2 * (d[0] + r2 * (d[1] + r2 * (d[2] + r2 * d[3]))));
  if (d.empty()) return r;
  const double k3 = d.size() > 4 ? d[4] : 0;
  const double above = 1 + r2 * (d[0] + r2 * (d[1] + r2 * k3));
  const double below = d.size() > 5 ? 1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])) : 1;
  return below > 0 ? r * above / below : 0;
}

Point Calibration::distorted(Point ideal) const {
  const double r = std::hypot(ideal.x, ideal.y);
  if (r < 1e-12) return ideal;
  if (data_.lens.model == LensModel::fisheye) {
    const double scale = radial(std::atan(r)) / r;
    return {ideal.x * scale, ideal.y * scale};
  }
  const auto& d = data_.lens.distortion;
  const double scale = radial(r) / r, p1 = d.empty() ? 0 : d[2], p2 = d.empty() ? 0 : d[3];
  return {ideal.x * scale + 2 * p1 * ideal.x * ideal.y + p2 * (r * r + 2 * ideal.x * ideal.x),
          ideal.y * scale + p1 * (r * r + 2 * ideal.y * ideal.y) + 2 * p2 * ideal.x * ideal.y};
}

// The direction (x, y, 1) in the camera's frame that a pixel shows.
std::optional<Point> Calibration::ideal(Point in_pixels) const {
  const Eigen::Vector3d bent = as_matrix(inverse_matrix_) * Eigen::Vector3d(in_pixels.x, in_pixels.y, 1);
  if (data_.lens.distortion.empty()) return Point{bent.x(), bent.y()};
  const double radius = std::hypot(bent.x(), bent.y());
  if (radius < 1e-12) return Point{bent.x(), bent.y()};
  // The radial part by Newton's method, within bounds: the distortion grows up to reach_.
  const bool fisheye = data_.lens.model == LensModel::fisheye;
  if (radial(reach_) < radius * (fisheye ? 1 : 0.98)) return {};
  double low = 0, high = reach_, found = std::min(radius, reach_);
  for (int i = 0; i < 60; ++i) {
    constexpr double h = 1e-6;
    const double off = radial(found) - radius;
    (off < 0 ? low : high) = found;
    double next = found - off * h / (radial(found + h) - radius - off);
    if (!(next >= low && next <= high)) next = (low + high) / 2;
    const double step = std::abs(next - found);
    found = next;
    if (step < 1e-13) break;
  }
  const double straight = (fisheye ? std::tan(found) : found) / radius;
  Point guess{bent.x() * straight, bent.y() * straight};
  if (fisheye || (data_.lens.distortion[2] == 0 && data_.lens.distortion[3] == 0)) return guess;
  // The tangential part by Newton's method with a numeric derivative.
  for (int i = 0; i < 8; ++i) {
    constexpr double h = 1e-6;
    const Point at = distorted(guess), right = distorted({guess.x + h, guess.y}),
                down = distorted({guess.x, guess.y + h});
    const double xx = (right.x - at.x) / h, yx = (right.y - at.y) / h, xy = (down.x - at.x) / h,
                 yy = (down.y - at.y) / h;
    const double determinant = xx * yy - xy * yx, off_x = bent.x() - at.x, off_y = bent.y() - at.y;
    if (!(determinant > 1e-9)) return {};
    guess.x += (yy * off_x - xy * off_y) / determinant;
    guess.y += (xx * off_y - yx * off_x) / determinant;
    if (std::abs(off_x) + std::abs(off_y) < 1e-12) break;
  }
  const Point there = distorted(guess);
  if (!(std::hypot(there.x - bent.x(), there.y - bent.y()) < 1e-6) || std::hypot(guess.x, guess.y) > reach_) return {};
  return guess;
}

std::optional<Point> Calibration::to_pixel(Point in_arena, double height_m) const {
  const Eigen::Vector3d seen =
      as_matrix(data_.rotation) * Eigen::Vector3d(in_arena.x, in_arena.y, height_m) + as_vector(data_.translation_m);
  if (!(seen.z() > 1e-6)) return {};
  const Point straight{seen.x() / seen.z(), seen.y() / seen.z()};
  const double radius = std::hypot(straight.x, straight.y);
  if ((data_.lens.model == LensModel::fisheye ? std::atan(radius) : radius) > reach_) return {};
  const Point bent = distorted(straight);
  const Matrix3& k = data_.lens.matrix;
  return Point{k[0] * bent.x + k[1] * bent.y + k[2], k[4] * bent.y + k[5]};
}

std::optional<Point> Calibration::to_arena(Point in_pixels, double height_m) const {
  const auto direction = ideal(in_pixels);
  if (!direction) return {};
  const Eigen::Vector3d sight = as_matrix(data_.rotation).transpose() * Eigen::Vector3d(direction->x, direction->y, 1);
  const double down = height_m - position_m_[2];
  if (!(down < 0) || !(sight.z() < -1e-9)) return {};
  const double along = down / sight.z();
  return Point{position_m_[0] + along * sight.x(), position_m_[1] + along * sight.y()};
}

std::optional<Calibration::Scale> Calibration::scale(Point in_arena, double height_m) const {
  constexpr double h = 0.001;
  const auto west = to_pixel({in_arena.x - h, in_arena.y}, height_m),
             east = to_pixel({in_arena.x + h, in_arena.y}, height_m);
  const auto south = to_pixel({in_arena.x, in_arena.y - h}, height_m),
             north = to_pixel({in_arena.x, in_arena.y + h}, height_m);
  if (!west || !east || !south || !north) return {};
  const double xx = (east->x - west->x) / (2 * h), yx = (east->y - west->y) / (2 * h);
  const double xy = (north->x - south->x) / (2 * h), yy = (north->y - south->y) / (2 * h);
  // Singular values of the mapping's derivative.
  const double sum = xx * xx + yx * yx + xy * xy + yy * yy, determinant = std::abs(xx * yy - xy * yx);
  const double root = std::sqrt(std::max(0.0, sum * sum / 4 - determinant * determinant));
  return Scale{std::sqrt(sum / 2 + root), std::sqrt(std::max(0.0, sum / 2 - root))};
}

double Calibration::inside_px(Point in_pixels) const {
  return std::min(
      {in_pixels.x, in_pixels.y, data_.lens.width_px - 1 - in_pixels.x, data_.lens.height_px - 1 - in_pixels.y});
}

}  // namespace arkmesh::tracker
