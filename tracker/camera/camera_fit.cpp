#include "tracker/camera/camera_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

namespace arkmesh::tracker {
namespace {

constexpr double clear_margin = 0.8;  // a fisheye is taken when its error is below this part of the pinhole's,
constexpr double blind_margin = 1.5;  // or below this multiple when the pinhole cannot see to the picture's sides
constexpr double worst_error_px = 5;  // a fit worse than this is none
constexpr std::size_t min_pictures = 3;
constexpr double same_view_px = 1;   // corners that all lie as near to those of another picture are that picture again
constexpr double min_slant_deg = 8;  // between two boards at least: of boards that lie alike no focal length follows
constexpr double min_covered = 0.5;  // of the picture's width and height
constexpr double worst_focal = 0.01, worst_aspect = 0.015, worst_middle = 0.12;  // of the focal length; of the sides
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Fit {
  cv::Mat matrix = cv::Mat::eye(3, 3, CV_64F), distortion;
  std::vector<cv::Mat> rotations;  // of each board
  double error_px = infinity;
  double focal_sigma_px = 0;  // 0: not known
};

Lens as_lens(LensModel model, cv::Size size, const Fit& fit) {
  Lens lens;
  lens.model = model;
  lens.width_px = size.width;
  lens.height_px = size.height;
  std::copy(fit.matrix.begin<double>(), fit.matrix.end<double>(), lens.matrix.begin());
  lens.distortion.assign(fit.distortion.begin<double>(), fit.distortion.end<double>());
  return lens;
}

// The inner corners to a pixel or two. In small pictures the search is quick also where there is no such board, which
// in a large one takes half a minute; what is too fine for them is left to the other method.
std::vector<cv::Point2f> find_chessboard(const cv::Mat& grey, cv::Size size) {
  constexpr double small_px = 640;
  const double scale = std::min(1.0, small_px / std::max(grey.cols, grey.rows));
  cv::Mat small = grey;
  if (scale < 1) cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  std::vector<cv::Point2f> corners;
  if (cv::findChessboardCorners(small, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE)) {
    for (cv::Point2f& at : corners) at = (at + cv::Point2f(0.5f, 0.5f)) / scale - cv::Point2f(0.5f, 0.5f);
    return corners;
  }
  if (!cv::findChessboardCornersSB(grey, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) corners.clear();
  return corners;
}

// Refines the corners within `half` pixels. OpenCV 4.10 finds some beside a board's dark rim many pixels off, from
// where the refinement wanders out of its window and changes nothing: those begin again where two in line with them
// say.
void refine(const cv::Mat& grey, cv::Size size, int half, std::vector<cv::Point2f>& corners) {
  const auto refined = [&](std::vector<cv::Point2f> at) {
    cv::cornerSubPix(grey, at, cv::Size(half, half), cv::Size(-1, -1),
                     cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-3));
    return at;
  };
  const std::vector<cv::Point2f> found = std::exchange(corners, refined(corners));
  const auto settled = [&](int column, int row) {
    return column >= 0 && row >= 0 && column < size.width && row < size.height &&
           corners[row * size.width + column] != found[row * size.width + column];
  };
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    const int column = i % size.width, row = i / size.width;
    if (settled(column, row)) continue;
    for (const cv::Point& step : {cv::Point(0, -1), cv::Point(0, 1), cv::Point(-1, 0), cv::Point(1, 0)}) {
      if (!settled(column + step.x, row + step.y) || !settled(column + 2 * step.x, row + 2 * step.y)) continue;
      const int next = i + step.y * size.width + step.x, after = next + step.y * size.width + step.x;
      corners[i] = refined({2 * corners[next] - corners[after]}).front();
      break;
    }
  }
}

// Whether every side of the picture is within the lens's reach: beyond it a strong distortion folds over.
bool sees_sides(const Lens& lens) {
  try {
    CameraData data;
    data.lens = lens;
    const Calibration camera(data);
    const double right = lens.width_px - 1, bottom = lens.height_px - 1;
    for (const Point& at :
         {Point{0, bottom / 2}, Point{right, bottom / 2}, Point{right / 2, 0}, Point{right / 2, bottom}})
      if (!camera.to_arena(at, 0)) return false;
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
}

// Whether all marks lie on nearly one line of the arena: the smaller spread is below a tenth of the larger.
bool narrow(std::span<const Mark> marks) {
  const double n = static_cast<double>(marks.size());
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (const Mark& mark : marks) x += mark.in_arena.x / n, y += mark.in_arena.y / n;
  for (const Mark& mark : marks) {
    const double off_x = mark.in_arena.x - x, off_y = mark.in_arena.y - y;
    xx += off_x * off_x, xy += off_x * off_y, yy += off_y * off_y;
  }
  const double root = std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
  return !((xx + yy) / 2 - root > 0.01 * ((xx + yy) / 2 + root));
}

}  // namespace

struct LensFit::Boards {
  ChessboardSize board;
  cv::Size size;
  std::vector<std::vector<cv::Point2f>> corners;
  int copies = 0;                   // pictures that show a board as another one does
  std::vector<cv::Point3f> points;  // of the board, millimetres

  Fit pinhole() const {
    Fit fit;
    std::vector<cv::Mat> translations;
    cv::Mat sigmas;
    try {
      const std::vector<std::vector<cv::Point3f>> all(corners.size(), points);
      fit.error_px = cv::calibrateCamera(all, corners, size, fit.matrix, fit.distortion, fit.rotations, translations,
                                         sigmas, cv::noArray(), cv::noArray());
      fit.focal_sigma_px = std::max(sigmas.at<double>(0), sigmas.at<double>(1));
      fit.distortion = fit.distortion.reshape(1, 1).colRange(0, 5).clone();
    } catch (const cv::Exception&) {
      fit.error_px = infinity;
    }
    return fit;
  }

  Fit fisheye() const {
    Fit best;
    // The fit needs a start near the truth: fisheyes differ mostly in focal length.
    for (const double part : {0.25, 0.35, 0.5, 0.7, 1.0}) {
      Fit fit;
      const double focal = part * std::max(size.width, size.height);
      fit.matrix =
          (cv::Mat_<double>(3, 3) << focal, 0, (size.width - 1) / 2.0, 0, focal, (size.height - 1) / 2.0, 0, 0, 1);
      fit.distortion = cv::Mat::zeros(4, 1, CV_64F);
      std::vector<cv::Mat> translations;
      const int flags =
          cv::fisheye::CALIB_USE_INTRINSIC_GUESS | cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW;
      try {
        const std::vector<std::vector<cv::Point3f>> all(corners.size(), points);
        fit.error_px =
            cv::fisheye::calibrate(all, corners, size, fit.matrix, fit.distortion, fit.rotations, translations, flags,
                                   cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-9));
      } catch (const cv::Exception&) {
        continue;
      }
      const bool finite = std::isfinite(fit.error_px) && cv::checkRange(fit.matrix) && cv::checkRange(fit.distortion);
      if (finite && fit.error_px < best.error_px) best = fit;
    }
    return best;
  }

  // The largest angle between two boards, degrees.
  static double slant_deg(const std::vector<cv::Mat>& rotations) {
    std::vector<cv::Vec3d> up;
    for (const cv::Mat& each : rotations) {
      cv::Matx33d turned;
      cv::Rodrigues(each, turned);
      up.emplace_back(turned(0, 2), turned(1, 2), turned(2, 2));
    }
    double least = 1;
    for (const cv::Vec3d& a : up)
      for (const cv::Vec3d& b : up) least = std::min(least, a.dot(b));
    return std::acos(std::clamp(least, -1.0, 1.0)) * 180 / CV_PI;
  }

  std::vector<std::string> doubts(const Fit& fit) const {
    std::vector<std::string> out;
    const double fx = fit.matrix.at<double>(0, 0), fy = fit.matrix.at<double>(1, 1);
    if (fit.focal_sigma_px > worst_focal * fx)
      out.push_back(fmt::format("the focal length {:.0f} px is uncertain by {:.0f} px; add pictures at other slants",
                                fx, fit.focal_sigma_px));
    if (std::abs(fx / fy - 1) > worst_aspect)
      out.push_back(fmt::format(
          "the focal lengths {:.0f} x {:.0f} px differ more than any camera's; add pictures at other slants", fx, fy));
    const double off_x = fit.matrix.at<double>(0, 2) / (size.width - 1) - 0.5,
                 off_y = fit.matrix.at<double>(1, 2) / (size.height - 1) - 0.5;
    if (std::max(std::abs(off_x), std::abs(off_y)) > worst_middle)
      out.push_back(fmt::format(
          "the principal point {:.0f},{:.0f} is far from the pictures' centre; add pictures at other slants",
          fit.matrix.at<double>(0, 2), fit.matrix.at<double>(1, 2)));
    std::vector<cv::Point2f> all;
    for (const auto& found : corners) all.insert(all.end(), found.begin(), found.end());
    const cv::Rect covered = cv::boundingRect(all);
    if (covered.width < min_covered * size.width || covered.height < min_covered * size.height)
      out.push_back(
          fmt::format("boards cover {} x {} of {} x {} px, and the distortion outside is a guess; add pictures there",
                      covered.width, covered.height, size.width, size.height));
    return out;
  }

  // Mean length of a square's side in the pictures.
  double square_px() const {
    double sum = 0;
    for (const auto& found : corners) sum += cv::norm(found[1] - found[0]) + cv::norm(found[board.columns] - found[0]);
    return sum / (2.0 * static_cast<double>(corners.size()));
  }
};

LensFit::LensFit(const ChessboardSize& board) : boards_(std::make_unique<Boards>()) {
  boards_->board = board;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      boards_->points.emplace_back(static_cast<float>(column * board.square_mm),
                                   static_cast<float>(row * board.square_mm), 0.0f);
}

LensFit::~LensFit() = default;

bool LensFit::add(const cv::Mat& picture) {
  if (!boards_->corners.empty() && picture.size() != boards_->size)
    throw std::runtime_error(fmt::format(
        "has {} x {} pixels and the earlier ones have {} x {}; all must come from one camera at one resolution",
        picture.cols, picture.rows, boards_->size.width, boards_->size.height));
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  const cv::Size size(boards_->board.columns, boards_->board.rows);
  std::vector<cv::Point2f> corners = find_chessboard(grey, size);
  if (corners.empty()) return false;
  // The window of the refinement stays within a square.
  double least = infinity;
  for (std::size_t i = 1; i < corners.size(); ++i)
    if (i % size.width) least = std::min(least, cv::norm(corners[i] - corners[i - 1]));
  const int half = std::clamp(static_cast<int>(least / 3), 2, 8);
  refine(grey, size, half, corners);
  boards_->size = picture.size();
  for (const auto& other : boards_->corners)
    if (cv::norm(corners, other, cv::NORM_INF) < same_view_px) {
      ++boards_->copies;
      return true;
    }
  boards_->corners.push_back(std::move(corners));
  return true;
}

FittedLens LensFit::fit() const {
  if (boards_->copies > 0 && boards_->corners.size() < min_pictures)
    throw std::runtime_error(fmt::format(
        "{} of the pictures show the chessboard as others do, which leaves {} different, and {} are needed; "
        "hold it at different slants across the whole view",
        boards_->copies, boards_->corners.size(), min_pictures));
  if (boards_->corners.size() < min_pictures)
    throw std::runtime_error(
        fmt::format("a chessboard was found in {} pictures, and {} are needed; hold it at different slants across the "
                    "whole view, and count its inner corners: the search is for {} x {}, those of {} x {} squares",
                    boards_->corners.size(), min_pictures, boards_->board.columns, boards_->board.rows,
                    boards_->board.columns + 1, boards_->board.rows + 1));
  const Fit pinhole = boards_->pinhole(), fisheye = boards_->fisheye();
  const bool blind = pinhole.error_px < infinity && !sees_sides(as_lens(LensModel::pinhole, boards_->size, pinhole));
  const bool bent = fisheye.error_px < (blind ? blind_margin : clear_margin) * pinhole.error_px;
  const Fit& taken = bent ? fisheye : pinhole;
  if (!(taken.error_px < worst_error_px))
    throw std::runtime_error(
        fmt::format("no lens fits these pictures (the best is {:.1f} pixels off); are --board and the pictures right?",
                    taken.error_px));
  if (const double slant = Boards::slant_deg(taken.rotations); slant < min_slant_deg)
    throw std::runtime_error(
        fmt::format("all chessboards have the same slant (within {:.0f} degrees), which does not determine the focal "
                    "length; hold them at slants of 20 to 40 degrees to each side",
                    slant));
  FittedLens fitted;
  fitted.doubts = boards_->doubts(taken);
  fitted.lens = as_lens(bent ? LensModel::fisheye : LensModel::pinhole, boards_->size, taken);
  fitted.error_px = taken.error_px;
  fitted.other_error_px = bent ? pinhole.error_px : fisheye.error_px;
  fitted.error_mm = taken.error_px * boards_->board.square_mm / boards_->square_px();
  fitted.pictures = static_cast<int>(boards_->corners.size());
  return fitted;
}

CameraData place_camera(const Lens& lens, std::span<const Mark> marks, double arena_width_m, double arena_height_m) {
  if (marks.size() < 4)
    throw std::runtime_error(fmt::format("a camera's pose needs four marks or more, not {}", marks.size()));
  CameraData data;
  data.lens = lens;
  data.arena_width_m = arena_width_m;
  data.arena_height_m = arena_height_m;
  data.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  // Straightened, the marks are seen by the simplest camera there is.
  const Calibration straightener(data);
  std::vector<cv::Point2d> straight;
  std::vector<cv::Point3d> arena;
  for (const Mark& mark : marks) {
    // 1 m above the arena the place on it is the direction, turned over.
    const auto at = straightener.to_arena(mark.in_pixels, 0);
    if (!at)
      throw std::runtime_error(
          fmt::format("the point {:.0f},{:.0f} is outside this lens's view", mark.in_pixels.x, mark.in_pixels.y));
    straight.emplace_back(at->x, -at->y);
    arena.emplace_back(mark.in_arena.x, mark.in_arena.y, 0);
  }
  if (narrow(marks))
    throw std::runtime_error("the marks lie on one line; add some on both sides of it, across the camera's whole view");
  const char* const wrong =
      "no camera can see these points at these places of the arena; are the points and --arena right?";
  try {
    cv::Mat turned, moved, rotation;
    if (!cv::solvePnP(arena, straight, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turned, moved, false,
                      cv::SOLVEPNP_IPPE))
      throw std::runtime_error(wrong);
    cv::solvePnPRefineLM(arena, straight, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turned, moved);
    cv::Rodrigues(turned, rotation);
    std::copy(rotation.begin<double>(), rotation.end<double>(), data.rotation.begin());
    std::copy(moved.begin<double>(), moved.end<double>(), data.translation_m.begin());
  } catch (const cv::Exception&) {
    throw std::runtime_error(wrong);
  }

  try {
    const Calibration placed(data);
    double square_px = 0, square_m = 0;
    for (const Mark& mark : marks) {
      const auto pixel = placed.to_pixel(mark.in_arena, 0);
      const auto place = placed.to_arena(mark.in_pixels, 0);
      if (!pixel || !place) throw std::invalid_argument("one is outside this lens's view");
      square_px += std::pow(pixel->x - mark.in_pixels.x, 2) + std::pow(pixel->y - mark.in_pixels.y, 2);
      square_m += std::pow(place->x - mark.in_arena.x, 2) + std::pow(place->y - mark.in_arena.y, 2);
    }
    data.error_px = std::sqrt(square_px / static_cast<double>(marks.size()));
    data.error_mm = 1000 * std::sqrt(square_m / static_cast<double>(marks.size()));
  } catch (const std::invalid_argument& why) {
    throw std::runtime_error(fmt::format(
        "these points put the camera at an impossible place ({}); are the points and --arena right?", why.what()));
  }
  return data;
}

CameraData place_camera(const Lens& lens, const std::vector<Point>& corners, double arena_width_m,
                        double arena_height_m) {
  if (corners.size() != 4)
    throw std::runtime_error(
        fmt::format("the arena has four corners, not {}; give each as --corner x,y", corners.size()));
  for (int i = 0; i < 4; ++i)
    if (!(turn(corners[i], corners[(i + 1) % 4], corners[(i + 2) % 4]) > 0))
      throw std::runtime_error(
          "the corners must be in clockwise order from the arena's north-west one, as they are in the picture");
  const double east = arena_width_m / 2, north = arena_height_m / 2;
  const Mark marks[] = {{corners[0], {-east, north}},
                        {corners[1], {east, north}},
                        {corners[2], {east, -north}},
                        {corners[3], {-east, -north}}};
  return place_camera(lens, marks, arena_width_m, arena_height_m);
}

}  // namespace arkmesh::tracker
