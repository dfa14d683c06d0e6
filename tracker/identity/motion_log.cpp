#include "tracker/identity/motion_log.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace arkmesh::tracker {
namespace {

constexpr double step_s = 0.4;

}  // namespace

double MotionLog::path_speed_m_s(double window_s) const {
  if (places_.empty()) return 0;
  const double from_s = places_.back().at_s - window_s - 1e-9;
  const Place* last = nullptr;
  double length_m = 0, lasted_s = 0;
  for (const Place& place : places_) {
    if (place.at_s < from_s) continue;
    if (!last) {
      last = &place;
    } else if (place.at_s - last->at_s >= step_s - 1e-9) {
      length_m += std::hypot(place.x_m - last->x_m, place.y_m - last->y_m);
      lasted_s += place.at_s - last->at_s;
      last = &place;
    }
  }
  return lasted_s > 0 ? length_m / lasted_s : 0;
}

double MotionLog::net_speed_m_s() const {
  if (lasted_s() <= 0) return 0;
  const Place &first = places_.front(), &last = places_.back();
  return std::hypot(last.x_m - first.x_m, last.y_m - first.y_m) / lasted_s();
}

std::optional<double> MotionLog::came_back_s(double away_m, double near_m) const {
  bool was_away = false;
  for (const Place& place : places_) {
    const double from_first_m = std::hypot(place.x_m - places_.front().x_m, place.y_m - places_.front().y_m);
    was_away = was_away || from_first_m > away_m;
    if (was_away && from_first_m < near_m) return place.at_s - places_.front().at_s;
  }
  return std::nullopt;
}

double MotionLog::mean_off_chord_m() const {
  if (places_.size() < 3) return 0;
  const Place &first = places_.front(), &last = places_.back();
  const double x = last.x_m - first.x_m, y = last.y_m - first.y_m, length_m = std::hypot(x, y);
  double sum_m = 0;
  for (const Place& place : places_) {
    const double dx = place.x_m - first.x_m, dy = place.y_m - first.y_m;
    sum_m += length_m > 0 ? std::abs(x * dy - y * dx) / length_m : std::hypot(dx, dy);
  }
  return sum_m / static_cast<double>(places_.size());
}

double MotionLog::course_rate_rad_s() const {
  const std::size_t n = places_.size();
  if (n < 4) return 0;
  const Place &a = places_.front(), &b = places_[n / 3], &c = places_[n - 1 - n / 3], &d = places_.back();
  const double x1 = b.x_m - a.x_m, y1 = b.y_m - a.y_m, x2 = d.x_m - c.x_m, y2 = d.y_m - c.y_m;
  const double between_s = (c.at_s + d.at_s - a.at_s - b.at_s) / 2;
  if (between_s <= 0 || (x1 == 0 && y1 == 0) || (x2 == 0 && y2 == 0)) return 0;
  return std::atan2(x1 * y2 - y1 * x2, x1 * x2 + y1 * y2) / between_s;
}

// x^2 + y^2 = 2 a x + 2 b y + c, by least squares.
MotionLog::Circle MotionLog::circle() const {
  const auto n = static_cast<Eigen::Index>(places_.size());
  if (n < 4) return {};
  Eigen::MatrixX3d left(n, 3);
  Eigen::VectorXd right(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Place& place = places_[static_cast<std::size_t>(i)];
    const double x = place.x_m - places_.front().x_m, y = place.y_m - places_.front().y_m;
    left.row(i) << 2 * x, 2 * y, 1;
    right[i] = x * x + y * y;
  }
  const auto decomposed = left.colPivHouseholderQr();
  if (decomposed.rank() < 3) return {};
  const Eigen::Vector3d solution = decomposed.solve(right);
  const double square = solution[2] + solution[0] * solution[0] + solution[1] * solution[1];
  if (!(square > 0)) return {};
  Circle out{.radius_m = std::sqrt(square)};
  double sum = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double off = std::hypot(left(i, 0) / 2 - solution[0], left(i, 1) / 2 - solution[1]) - out.radius_m;
    sum += off * off;
  }
  out.off_m = std::sqrt(sum / static_cast<double>(n));
  return out;
}

}  // namespace arkmesh::tracker
