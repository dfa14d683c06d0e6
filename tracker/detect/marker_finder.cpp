#include "tracker/detect/marker_finder.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/core/version.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

namespace arkmesh::tracker {
namespace {

struct NamedFamily {
  const char* name;
  int dictionary, squares, numbers;
};
constexpr std::array<NamedFamily, 5> named_families{{{"apriltag_36h11", cv::aruco::DICT_APRILTAG_36h11, 8, 587},
                                                     {"apriltag_16h5", cv::aruco::DICT_APRILTAG_16h5, 6, 30},
                                                     {"aruco_4x4_50", cv::aruco::DICT_4X4_50, 6, 50},
                                                     {"aruco_4x4_250", cv::aruco::DICT_4X4_250, 6, 250},
                                                     {"aruco_5x5_250", cv::aruco::DICT_5X5_250, 7, 250}}};

const NamedFamily& family_of(const std::string& name) {
  return *std::ranges::find(named_families, name, &NamedFamily::name);
}

constexpr int smallest_side_px = 10;

}  // namespace

// OpenCV's interface changed in 4.7.
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
struct Aruco {
  cv::aruco::Dictionary dictionary;
  cv::aruco::DetectorParameters parameters;
  explicit Aruco(int name) : dictionary(cv::aruco::getPredefinedDictionary(name)) {}
  cv::aruco::DetectorParameters& settings() { return parameters; }
  void detect(const cv::Mat& grey, std::vector<std::vector<cv::Point2f>>& corners, std::vector<int>& numbers) const {
    cv::aruco::ArucoDetector(dictionary, parameters).detectMarkers(grey, corners, numbers);
  }
  void draw(int number, int side_px, cv::Mat& out) const {
    cv::aruco::generateImageMarker(dictionary, number, side_px, out, 1);
  }
};
#else
struct Aruco {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  explicit Aruco(int name) : dictionary(cv::aruco::getPredefinedDictionary(name)) {}
  cv::aruco::DetectorParameters& settings() { return *parameters; }
  void detect(const cv::Mat& grey, std::vector<std::vector<cv::Point2f>>& corners, std::vector<int>& numbers) const {
    cv::aruco::detectMarkers(grey, dictionary, corners, numbers, parameters);
  }
  void draw(int number, int side_px, cv::Mat& out) const { cv::aruco::drawMarker(dictionary, number, side_px, out, 1); }
};
#endif

Point Marker::middle_px() const {
  // where the diagonals meet: that is the middle also of a marker seen aslant
  const auto& [a, b, c, d] = corners_px;
  const double cross = (c.x - a.x) * (d.y - b.y) - (c.y - a.y) * (d.x - b.x);
  const double along = ((b.x - a.x) * (d.y - b.y) - (b.y - a.y) * (d.x - b.x)) / cross;
  return {a.x + along * (c.x - a.x), a.y + along * (c.y - a.y)};
}

double Marker::side_px() const {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point &a = corners_px[i], &b = corners_px[(i + 1) % 4];
    longest = std::max(longest, std::hypot(a.x - b.x, a.y - b.y));
  }
  return longest;
}

struct MarkerFinder::Family {
  Aruco aruco;
};

const std::vector<std::string>& MarkerFinder::families() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> out;
    for (const NamedFamily& family : named_families) out.emplace_back(family.name);
    return out;
  }();
  return all;
}

int MarkerFinder::numbers(const std::string& family) {
  return family_of(family).numbers;
}

int MarkerFinder::squares(const std::string& family) {
  return family_of(family).squares;
}

MarkerFinder::MarkerFinder(const std::string& family)
    : family_(std::make_unique<Family>(Family{Aruco(family_of(family).dictionary)})) {
  auto& settings = family_->aruco.settings();
  settings.cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  settings.minMarkerDistanceRate = 0.01;  // else the white rim's outer edge is taken instead of the marker's
  settings.cornerRefinementWinSize = 3;   // less than a square of the pattern, or it finds the pattern's corners
}

MarkerFinder::~MarkerFinder() = default;
MarkerFinder::MarkerFinder(MarkerFinder&&) noexcept = default;

std::vector<Marker> MarkerFinder::find(const cv::Mat& bgr, cv::Rect part, std::vector<int>* twice) const {
  part &= cv::Rect(0, 0, bgr.cols, bgr.rows);
  if (part.width < smallest_side_px || part.height < smallest_side_px) return {};
  cv::Mat grey = bgr(part);
  if (grey.channels() == 3) cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
  // sizes of windows and markers are shares of the picture's size there
  auto aruco = family_->aruco;
  const double longest_px = std::max(part.width, part.height);
  aruco.settings().minMarkerPerimeterRate = 4 * smallest_side_px / longest_px;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> numbers;
  aruco.detect(grey, corners, numbers);
  std::vector<Marker> out;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Marker& marker = out.emplace_back(Marker{numbers[i], {}});
    for (std::size_t k = 0; k < 4; ++k)
      marker.corners_px[k] = {corners[i][k].x + static_cast<double>(part.x),
                              corners[i][k].y + static_cast<double>(part.y)};
  }
  std::ranges::stable_sort(out, {}, &Marker::number);
  // one marker may be found with several thresholds
  const auto is_same = [](const Marker& a, const Marker& b) {
    return a.number == b.number && std::hypot(a.middle_px().x - b.middle_px().x, a.middle_px().y - b.middle_px().y) <
                                       std::max(a.side_px(), b.side_px()) / 2;
  };
  out.erase(std::unique(out.begin(), out.end(), is_same), out.end());
  std::set<int> again;
  for (std::size_t i = 1; i < out.size(); ++i)
    if (out[i].number == out[i - 1].number) again.insert(out[i].number);
  std::erase_if(out, [&](const Marker& marker) { return again.contains(marker.number); });
  if (twice) twice->insert(twice->end(), again.begin(), again.end());
  return out;
}

cv::Mat marker_picture(const std::string& family, int number, int pixels_a_square) {
  cv::Mat out;
  Aruco(family_of(family).dictionary).draw(number, family_of(family).squares * pixels_a_square, out);
  cv::copyMakeBorder(out, out, pixels_a_square, pixels_a_square, pixels_a_square, pixels_a_square, cv::BORDER_CONSTANT,
                     cv::Scalar::all(255));
  return out;
}

}  // namespace arkmesh::tracker
