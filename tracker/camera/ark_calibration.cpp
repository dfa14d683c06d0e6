// Reads what ARK's arena calibration writes: cameras as rotations of one common eye, and the arena's corners in the
// overview that was stitched from them. Facts of the format: DiODeProject/KilobotArenaCalibration,
// DiODeProject/KilobotArena kilobottracker.cpp.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cctype>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tracker/camera/calibration_file.hpp"
#include "tracker/camera/lower_case.hpp"

namespace arkmesh::tracker {
namespace {

[[noreturn]] void refuse_file(const std::filesystem::path& file, const std::string& sentence) {
  throw std::runtime_error(fmt::format("{}: {}", file.string(), sentence));
}

std::optional<Eigen::Matrix3d> matrix_in(const cv::FileNode& node) {
  if (!node.isMap()) return {};
  cv::Mat matrix;
  node >> matrix;
  if (matrix.rows != 3 || matrix.cols != 3 || matrix.channels() != 1) return {};
  matrix.convertTo(matrix, CV_64F);
  if (!cv::checkRange(matrix)) return {};
  return Eigen::Matrix3d(Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.ptr<double>()));
}

// All 3 x 3 matrices under a name: a list of them, or one each with a number behind the name (K0, K_1, ...), whatever
// the letters' case.
std::vector<Eigen::Matrix3d> matrices(const cv::FileStorage& in, const std::string& name) {
  std::vector<Eigen::Matrix3d> found;
  for (const cv::FileNode& node : in.root()) {
    std::string key = lower_case(node.name());
    while (!key.empty() && (std::isdigit(static_cast<unsigned char>(key.back())) || key.back() == '_')) key.pop_back();
    if (key != name && key != name + "s") continue;
    if (const auto one = matrix_in(node))
      found.push_back(*one);
    else if (node.isSeq())
      for (const cv::FileNode& element : node)
        if (const auto matrix = matrix_in(element)) found.push_back(*matrix);
  }
  return found;
}

std::optional<cv::Point2f> corner(const cv::FileStorage& in, char digit) {
  for (const cv::FileNode& node : in.root()) {
    const std::string key = lower_case(node.name());
    if (!key.starts_with("corner") || key.back() != digit || !node.isSeq() || node.size() != 2) continue;
    return cv::Point2f(static_cast<float>(node[0]), static_cast<float>(node[1]));
  }
  return {};
}

// Upper left, upper right, lower left, lower right of an area worth the name: going round, every turn is to the right.
bool go_round(const std::vector<cv::Point2f>& corners) {
  const cv::Point2f round[] = {corners[0], corners[1], corners[3], corners[2]};
  for (int i = 0; i < 4; ++i) {
    const cv::Point2f there = round[(i + 1) % 4] - round[i], on = round[(i + 2) % 4] - round[(i + 1) % 4];
    // A hundredth of a right angle's area: clicked twice, or all on one line.
    if (!(there.cross(on) > 0.01 * cv::norm(there) * cv::norm(on)) || !(cv::norm(there) > 1)) return false;
  }
  return true;
}

// A pixel in the plane that all cameras of the file share.
Eigen::Vector2d in_plane(const Eigen::Matrix3d& onto_plane, double x_px, double y_px) {
  const Eigen::Vector3d at = onto_plane * Eigen::Vector3d(x_px, y_px, 1);
  return {at.x() / at.z(), at.y() / at.z()};
}

// The camera that sees the arena through this homography (arena metres to pixels) from that place.
CameraData camera_above(const Eigen::Matrix3d& to_pixels, const Eigen::Vector3d& place) {
  Eigen::Matrix3d all;
  all.col(0) = to_pixels.col(0);
  all.col(1) = to_pixels.col(1);
  // What the camera sees of its own place is nothing: that gives the column for height.
  all.col(2) = -(to_pixels.col(0) * place.x() + to_pixels.col(1) * place.y() + to_pixels.col(2)) / place.z();
  // Upright triangular times rotation, by the QR decomposition of the reversed matrix.
  const Eigen::Matrix3d reversed = (Eigen::Matrix3d() << 0, 0, 1, 0, 1, 0, 1, 0, 0).finished();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr((reversed * all).transpose());
  const Eigen::Matrix3d q = qr.householderQ(), r = qr.matrixQR().triangularView<Eigen::Upper>();
  Eigen::Matrix3d k = reversed * r.transpose() * reversed, rotation = reversed * q.transpose();
  for (int i = 0; i < 3; ++i)
    if (k(i, i) < 0) {
      k.col(i) *= -1;
      rotation.row(i) *= -1;
    }
  if (rotation.determinant() < 0) rotation *= -1;  // the homography's sign is free
  k /= k(2, 2);
  const Eigen::Vector3d translation = -rotation * place;
  CameraData data;
  using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  k(1, 0) = k(2, 0) = k(2, 1) = 0;
  Eigen::Map<RowMatrix>(data.lens.matrix.data()) = k;
  Eigen::Map<RowMatrix>(data.rotation.data()) = rotation;
  Eigen::Map<Eigen::Vector3d>(data.translation_m.data()) = translation;
  return data;
}

}  // namespace

std::vector<CameraData> import_ark_calibration(const std::filesystem::path& file, const ArkArena& arena) try {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) refuse_file(file, "there is no such calibration file");
  const cv::FileStorage in(file.string(), cv::FileStorage::READ);
  if (!in.isOpened()) refuse_file(file, "is not a YAML or XML file as OpenCV writes it");
  const auto ks = matrices(in, "k"), rs = matrices(in, "r");
  std::vector<cv::Point2f> corners;
  for (const char digit : {'1', '2', '3', '4'})
    if (const auto found = corner(in, digit)) corners.push_back(*found);
  if (ks.empty() || ks.size() != rs.size() || ks.size() > 16 || corners.size() != 4)
    refuse_file(file, fmt::format("is not an ARK calibration: it needs equally many 3 x 3 matrices K and R, and "
                                  "corner1 to corner4, and contains {} K, {} R and {} corners",
                                  ks.size(), rs.size(), corners.size()));

  if (!go_round(corners))
    refuse_file(
        file,
        "its corners 1 to 4 are not an arena's: upper left, upper right, lower left, lower right of the overview, "
        "in pixels");

  // The frame of the overview: all pictures' corners on the common plane, as the stitching's plane projection finds it.
  std::vector<Eigen::Matrix3d> onto_plane;
  Eigen::Vector2d least(1e300, 1e300), most(-1e300, -1e300);
  for (std::size_t i = 0; i < ks.size(); ++i) {
    onto_plane.push_back(rs[i] * ks[i].inverse());
    for (const double x_px : {0.0, arena.width_px - 1.0})
      for (const double y_px : {0.0, arena.height_px - 1.0}) {
        const Eigen::Vector2d at = in_plane(onto_plane.back(), x_px, y_px);
        least = least.cwiseMin(at);
        most = most.cwiseMax(at);
      }
  }
  if (!least.allFinite() || !most.allFinite() || !((most - least).minCoeff() > 0))
    refuse_file(file, "its matrices K and R do not see one common plane");

  // The overview's corners, on the plane, are the arena's.
  std::vector<cv::Point2f> on_plane, in_arena;
  const float east = static_cast<float>(arena.arena_width_m / 2), north = static_cast<float>(arena.arena_height_m / 2);
  for (int i = 0; i < 4; ++i) {
    const cv::Point2f at = corners[i] / static_cast<float>(arena.overview_px);
    const Eigen::Vector2d spot = least + Eigen::Vector2d(at.x, at.y).cwiseProduct(most - least);
    on_plane.emplace_back(static_cast<float>(spot.x()), static_cast<float>(spot.y()));
    in_arena.emplace_back(i % 2 ? east : -east, i < 2 ? north : -north);
  }
  const cv::Mat to_plane = cv::getPerspectiveTransform(in_arena, on_plane);
  const Eigen::Matrix3d arena_to_plane(
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(to_plane.ptr<double>()));

  std::vector<CameraData> cameras;
  for (std::size_t i = 0; i < ks.size(); ++i) {
    Eigen::Matrix3d to_pixels = onto_plane[i].inverse() * arena_to_plane;
    const Eigen::Vector3d middle =
        to_pixels.inverse() * Eigen::Vector3d((arena.width_px - 1) / 2.0, (arena.height_px - 1) / 2.0, 1);
    const Eigen::Vector3d place(middle.x() / middle.z(), middle.y() / middle.z(), arena.camera_height_m);
    // What is in the middle of the picture is in front of the camera.
    if ((to_pixels * Eigen::Vector3d(place.x(), place.y(), 1)).z() < 0) to_pixels *= -1;
    CameraData data = camera_above(to_pixels, place);
    data.lens.width_px = arena.width_px;
    data.lens.height_px = arena.height_px;
    data.arena_width_m = arena.arena_width_m;
    data.arena_height_m = arena.arena_height_m;
    try {
      cameras.push_back(Calibration(std::move(data)).data());
    } catch (const std::invalid_argument& wrong) {
      refuse_file(file, fmt::format("camera {}: {}", i, wrong.what()));
    }
  }
  return cameras;
} catch (const cv::Exception&) {
  refuse_file(file, "is damaged or not a YAML or XML file as OpenCV writes it");
}

}  // namespace arkmesh::tracker
