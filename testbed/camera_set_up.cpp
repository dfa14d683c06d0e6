#include "testbed/camera_set_up.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "hal/platforms/kilobot/body.hpp"
#include "tracker/source.hpp"
#include "tracker/table_corners.hpp"

namespace arkmesh::testbed {
namespace {

cv::Mat read_picture(const std::string& file) {
  cv::Mat picture = tracker::read_picture(file);
  if (picture.empty()) throw std::runtime_error(fmt::format("{} is damaged or no picture", file));
  return picture;
}

}  // namespace

tracker::FittedLens fit_lens(const std::vector<std::string>& pictures, const tracker::ChessboardSize& board,
                             const std::function<void(const std::string& picture, bool found)>& looked) {
  tracker::LensFit fit(board);
  for (const std::string& file : pictures) {
    bool found = false;
    try {
      found = fit.add(read_picture(file));
    } catch (const std::runtime_error& wrong) {
      const std::string what = wrong.what();
      throw std::runtime_error(what.starts_with(file) ? what : fmt::format("{} {}", file, what));
    }
    looked(file, found);
  }
  return fit.fit();
}

std::vector<tracker::Point> find_corners(const std::string& file, const tracker::Lens& lens) {
  const cv::Mat picture = read_picture(file);
  if (picture.cols != lens.width_px || picture.rows != lens.height_px)
    throw std::runtime_error(
        fmt::format("{} is {} x {} pixels, the chessboard pictures are {} x {}; use one camera at one resolution", file,
                    picture.cols, picture.rows, lens.width_px, lens.height_px));
  const std::vector<tracker::Point> corners = tracker::find_table_corners(picture);
  if (corners.empty())
    throw std::runtime_error(fmt::format(
        "{}: no table stands out from its surroundings; give its corners with --corner x,y, four times", file));
  return corners;
}

void draw_arena(const std::string& png, const std::string& file, const tracker::CameraData& camera) {
  cv::Mat picture = file.empty() ? cv::Mat(camera.lens.height_px, camera.lens.width_px, CV_8UC3, cv::Scalar::all(60))
                                 : read_picture(file);
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
  bool written = false;
  try {
    written = cv::imwrite(png, picture);
  } catch (const cv::Exception&) {
    // Said below.
  }
  if (!written)
    throw std::runtime_error(
        fmt::format("{} cannot be written: give a name ending in .png in a folder that exists", png));
}

std::optional<double> robot_width_px(const tracker::CameraData& camera, tracker::Point at) {
  const auto scale = tracker::Calibration(camera).scale(at, tracker::board_height_m);
  if (!scale) return {};
  return (scale->largest + scale->smallest) / 2 * 2 * hal::kilobot::body_radius_m;
}

std::size_t keep_camera(const std::filesystem::path& file, const tracker::NamedCamera& camera) {
  std::vector<tracker::NamedCamera> cameras;
  if (std::filesystem::exists(file)) cameras = tracker::read_calibrations(file);
  const auto same = std::ranges::find(cameras, camera.name, &tracker::NamedCamera::name);
  if (same != cameras.end())
    same->data = camera.data;
  else
    cameras.push_back(camera);
  tracker::write_calibrations(file, cameras);
  return cameras.size();
}

}  // namespace arkmesh::testbed
