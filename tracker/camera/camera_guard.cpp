// Landmarks are followed by Lucas and Kanade's method with templates that are learnt once, so that nothing drifts.
#include "tracker/camera/camera_guard.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "tracker/detect/median.hpp"

namespace arkmesh::tracker {
namespace {

constexpr int side = Template::side, half = side / 2;
constexpr double min_likeness = 0.75;  // correlation with the template
constexpr double roughly_px = 0.3, precisely_px = 0.05;
constexpr std::size_t turns = 4;
constexpr double followed_px = 5;  // that a mark is followed without searching
constexpr std::size_t fewest_for_fit = 6;
constexpr int small_reach = 56;  // searching, in the downsampled image

// The patch round a place between pixels, smoothed as templates are, without its mean; false when it does not lie
// inside the picture.
bool patch(const cv::Mat& bgr, double x_px, double y_px, float* out) {
  const double left = x_px - half - 1, top = y_px - half - 1;
  const int x0 = static_cast<int>(std::floor(left)), y0 = static_cast<int>(std::floor(top));
  if (!(x0 >= 0 && y0 >= 0 && x0 + side + 3 <= bgr.cols && y0 + side + 3 <= bgr.rows)) return false;
  // between two pixels, and of three of these: of four
  const auto weights = [](float part) { return std::array{(1 - part) / 4, (2 - part) / 4, (1 + part) / 4, part / 4}; };
  const auto along = weights(static_cast<float>(left - x0)), across = weights(static_cast<float>(top - y0));
  std::array<std::array<float, side>, side + 3> rows;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    const cv::Vec3b* const pixels = bgr.ptr<cv::Vec3b>(y0 + static_cast<int>(y)) + x0;
    std::array<float, side + 3> grey;
    for (std::size_t x = 0; x < grey.size(); ++x) grey[x] = grey_of(pixels[x]);
    for (std::size_t x = 0; x < side; ++x)
      rows[y][x] = along[0] * grey[x] + along[1] * grey[x + 1] + along[2] * grey[x + 2] + along[3] * grey[x + 3];
  }
  float sum = 0;
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      const float value =
          across[0] * rows[y][x] + across[1] * rows[y + 1][x] + across[2] * rows[y + 2][x] + across[3] * rows[y + 3][x];
      out[y * side + x] = value;
      sum += value;
    }
  const float mean = sum / (side * side);
  for (int k = 0; k < side * side; ++k) out[k] -= mean;
  return true;
}

}  // namespace

void CameraGuard::learn(std::span<const Landmark> landmarks, const Calibration& calibration) {
  learnt_ = true;
  confirmed_ = false;
  amiss_ = 0;
  tried_.reset();
  found_.reset();
  marks_.clear();
  rough_block_ = rough_block(calibration.data().lens.width_px);
  for (const Landmark& landmark : landmarks) {
    const Point at{static_cast<double>(landmark.x_px), static_cast<double>(landmark.y_px)};
    const auto place = calibration.to_arena(at, 0);
    Template look = template_of(landmark);
    if (!place || look.xx * look.yy - look.xy * look.xy <= 0) continue;
    Mark& mark = marks_.emplace_back();
    mark.x_px = landmark.x_px, mark.y_px = landmark.y_px;
    mark.at_x_px = at.x, mark.at_y_px = at.y;
    mark.on_arena = *place;
    mark.look = std::move(look);
    mark.rough =
        cv::Mat(Landmark::rough_side, Landmark::rough_side, CV_8U, const_cast<std::uint8_t*>(landmark.rough.data()))
            .clone();
  }
}

// Follows a mark from a place where it may be; false when it is not to be seen near there.
bool CameraGuard::find(Mark& mark, const cv::Mat& bgr, double x_px, double y_px, double within_px) const {
  std::array<float, side * side> now;
  const Template& look = mark.look;
  const double from_x_px = x_px, from_y_px = y_px, determinant = look.xx * look.yy - look.xy * look.xy;
  double likeness = 0;
  for (int step = 0; step < 8; ++step) {
    if (!patch(bgr, x_px, y_px, now.data())) return false;
    double energy = 0, both = 0;
    for (std::size_t k = 0; k < now.size(); ++k) energy += now[k] * now[k], both += now[k] * look.grey[k];
    if (energy < 1) return false;
    likeness = both / std::sqrt(energy * look.energy);
    if (likeness < 0.2) return false;
    const auto light = static_cast<float>(std::sqrt(look.energy / energy));
    double off_x = 0, off_y = 0;
    for (std::size_t k = 0; k < now.size(); ++k) {
      const float error = now[k] * light - look.grey[k];
      off_x += look.along_x[k] * error, off_y += look.along_y[k] * error;
    }
    const double move_x = (look.yy * off_x - look.xy * off_y) / determinant,
                 move_y = (look.xx * off_y - look.xy * off_x) / determinant;
    x_px -= std::clamp(move_x, -2.0, 2.0), y_px -= std::clamp(move_y, -2.0, 2.0);
    if (std::hypot(x_px - from_x_px, y_px - from_y_px) > followed_px) return false;
    if (std::abs(move_x) + std::abs(move_y) < within_px) break;
  }
  mark.off_x_px = x_px - mark.at_x_px, mark.off_y_px = y_px - mark.at_y_px;
  return likeness >= min_likeness;
}

CameraGuard::Verdict CameraGuard::look(const cv::Mat& bgr, const Calibration& calibration) {
  if (marks_.size() < fewest_marks) return Verdict::in_place;
  const auto scale = calibration.scale({0, 0}, 0);
  const double max_px = std::max(settings_.tolerance_px, settings_.tolerance_m * (scale ? scale->smallest : 0));
  // By turns every fourth mark; when half of these are not seen where they belong, all of them. `seen` is what is
  // recognised.
  const auto compare = [&](std::size_t first, std::size_t step) {
    std::vector<double> off;
    std::size_t looked_at = 0;
    for (std::size_t i = first; i < marks_.size(); i += step, ++looked_at) {
      marks_[i].seen = find(marks_[i], bgr, marks_[i].at_x_px, marks_[i].at_y_px, step > 1 ? roughly_px : precisely_px);
      if (marks_[i].seen) off.push_back(std::hypot(marks_[i].off_x_px, marks_[i].off_y_px));
    }
    const bool recognised = static_cast<double>(off.size()) >=
                            std::max(4.0, (step > 1 ? 0.5 : settings_.min_seen) * static_cast<double>(looked_at));
    if (step == 1) seen_part_ = static_cast<double>(off.size()) / static_cast<double>(looked_at);
    off_px_ = off.empty() ? 0 : median(off);
    return recognised;
  };
  // The first picture must show it all.
  bool recognised = confirmed_ && compare(turn_++ % turns, turns);
  if (!recognised || off_px_ > max_px) recognised = compare(0, 1);
  if (recognised && off_px_ <= max_px) {
    confirmed_ = true;
    amiss_ = 0;
    tried_.reset();
    return Verdict::in_place;
  }
  if (++amiss_ % settings_.patience == 0) {
    const bool elsewhere = search(bgr, max_px);
    recognised = recognised || elsewhere;
    const auto now = fit(calibration);
    // twice the same: nobody has it in the hand any more
    if (now && tried_) {
      double apart_px = 0;
      for (const Mark& mark : marks_) {
        const auto a = now->to_pixel(mark.on_arena, 0), b = tried_->to_pixel(mark.on_arena, 0);
        apart_px = std::max(apart_px, a && b ? std::hypot(a->x - b->x, a->y - b->y) : 1e9);
      }
      if (apart_px < max_px) found_ = now;
    }
    tried_ = now;
  }
  return recognised ? Verdict::moved : Verdict::unrecognised;
}

// Where marks are that may be far from their places: first roughly, in downsampled images, then by what most of them
// agree on. Whether enough of them are seen there, and it is farther off than `max_px`.
bool CameraGuard::search(const cv::Mat& bgr, double max_px) {
  const cv::Mat small = downsampled_grey(bgr, rough_block_);
  const cv::Rect all(0, 0, small.cols, small.rows);
  std::vector<cv::Point2f> from, to;
  for (const Mark& mark : marks_) {
    const cv::Point learnt(static_cast<int>(mark.x_px / rough_block_), static_cast<int>(mark.y_px / rough_block_));
    const cv::Point near(static_cast<int>(mark.at_x_px / rough_block_), static_cast<int>(mark.at_y_px / rough_block_));
    const cv::Rect piece =
        rough_patch(static_cast<int>(mark.x_px), static_cast<int>(mark.y_px), rough_block_, small.size());
    const cv::Rect window =
        cv::Rect(near.x - small_reach, near.y - small_reach, 2 * small_reach + 1, 2 * small_reach + 1) & all;
    if (window.width <= piece.width || window.height <= piece.height) continue;
    cv::Mat likeness;
    cv::matchTemplate(small(window), mark.rough, likeness, cv::TM_CCOEFF_NORMED);
    double best = 0;
    cv::Point at;
    cv::minMaxLoc(likeness, nullptr, &best, nullptr, &at);
    if (best < 0.6) continue;
    from.emplace_back(static_cast<float>(mark.at_x_px), static_cast<float>(mark.at_y_px));
    to.emplace_back(
        static_cast<float>(mark.at_x_px + rough_block_ * (window.x + at.x - piece.x - (near.x - learnt.x))),
        static_cast<float>(mark.at_y_px + rough_block_ * (window.y + at.y - piece.y - (near.y - learnt.y))));
  }
  if (from.size() < fewest_for_fit) return false;
  std::vector<std::uint8_t> agrees;
  const cv::Mat whole = cv::estimateAffinePartial2D(from, to, agrees, cv::RANSAC, 2.0 * rough_block_ + 1);
  if (whole.empty() || cv::countNonZero(agrees) < static_cast<int>(fewest_for_fit)) return false;
  std::vector<double> off;
  for (Mark& mark : marks_) {
    const double x =
        whole.at<double>(0, 0) * mark.at_x_px + whole.at<double>(0, 1) * mark.at_y_px + whole.at<double>(0, 2);
    const double y =
        whole.at<double>(1, 0) * mark.at_x_px + whole.at<double>(1, 1) * mark.at_y_px + whole.at<double>(1, 2);
    mark.seen = find(mark, bgr, x, y, precisely_px);
    if (mark.seen) off.push_back(std::hypot(mark.off_x_px, mark.off_y_px));
  }
  return off.size() >= std::max(fewest_marks, marks_.size() / 3) && median(off) > max_px;
}

// The camera's place and direction that explain where the marks are seen, by Gauss and Newton's method from those that
// it had.
std::optional<Calibration> CameraGuard::fit(const Calibration& from) const {
  std::vector<const Mark*> seen;
  for (const Mark& mark : marks_)
    if (mark.seen) seen.push_back(&mark);
  const std::size_t enough = std::max(fewest_for_fit, marks_.size() / 3);
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const auto moved = [](const Calibration& camera, const Vector6& by) {
    CameraData data = camera.data();
    const Eigen::Vector3d turn = by.head<3>();
    const double angle = turn.norm();
    const Eigen::Matrix3d rotation =
        angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> old(data.rotation.data());
    Eigen::Map<Eigen::Vector3d> place(data.translation_m.data());
    // about the camera, in its own frame
    old = (rotation * old).eval();
    place = (rotation * place + by.tail<3>()).eval();
    return Calibration(std::move(data));
  };
  try {
    Calibration camera = from;
    for (int round = 0; round < 12; ++round) {
      if (seen.size() < enough) return std::nullopt;
      constexpr double h = 1e-5;
      std::vector<Calibration> beside;
      for (int i = 0; i < 6; ++i) beside.push_back(moved(camera, Vector6::Unit(i) * h));
      Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Identity() * 1e-3;
      Vector6 right = Vector6::Zero();
      std::vector<double> off;
      for (const Mark* mark : seen) {
        const auto at = camera.to_pixel(mark->on_arena, 0);
        if (!at) return std::nullopt;
        const Eigen::Vector2d error(mark->at_x_px + mark->off_x_px - at->x, mark->at_y_px + mark->off_y_px - at->y);
        Eigen::Matrix<double, 2, 6> slope;
        for (int i = 0; i < 6; ++i) {
          const auto other = beside[static_cast<std::size_t>(i)].to_pixel(mark->on_arena, 0);
          if (!other) return std::nullopt;
          slope.col(i) = Eigen::Vector2d(other->x - at->x, other->y - at->y) / h;
        }
        const double weight = 1 / (1 + error.squaredNorm());  // the odd one counts little
        square += weight * slope.transpose() * slope;
        right += weight * slope.transpose() * error;
        off.push_back(error.norm());
      }
      const Vector6 step = square.ldlt().solve(right);
      if (!step.allFinite() || step.norm() > 1) return std::nullopt;
      if (step.norm() < 1e-7 || round == 11) {
        // what does not fit at all was no mark
        const double typical = median(off);
        const auto fitting =
            std::count_if(off.begin(), off.end(), [&](double each) { return each < std::max(1.0, 3 * typical); });
        // with noise, landmarks fit a true position no better than those of an unmoved camera must
        if (typical > settings_.tolerance_px || static_cast<std::size_t>(fitting) < enough) return std::nullopt;
        return camera;
      }
      camera = moved(camera, step);
    }
  } catch (const std::invalid_argument&) {
    // no camera can hang like that
  }
  return std::nullopt;
}

std::optional<Calibration> CameraGuard::realigned() {
  auto out = std::exchange(found_, std::nullopt);
  if (!out) return out;
  for (Mark& mark : marks_) {
    if (const auto at = out->to_pixel(mark.on_arena, 0)) mark.at_x_px = at->x, mark.at_y_px = at->y;
  }
  confirmed_ = true;
  tried_.reset();
  amiss_ = 0;
  return out;
}

}  // namespace arkmesh::tracker
