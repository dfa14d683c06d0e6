#include "tracker/camera/arena_corners.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace arkmesh::tracker {
namespace {

constexpr double min_part = 0.1, largest_part = 0.98;  // of the picture
constexpr double straightness = 0.02;                  // of the outline's length: how far a lens may bend a side

std::vector<cv::Point> largest_quadrilateral(const cv::Mat& mask) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::vector<cv::Point> best;
  double best_area = min_part * mask.total();
  for (const auto& outline : outlines) {
    std::vector<cv::Point> hull, corners;
    cv::convexHull(outline, hull);
    const double area = cv::contourArea(hull);
    if (area <= best_area || area > largest_part * mask.total() || cv::contourArea(outline) < 0.85 * area) continue;
    cv::approxPolyDP(hull, corners, straightness * cv::arcLength(hull, true), true);
    // what the picture's border cuts shows no corners of its own
    const cv::Rect inside(1, 1, mask.cols - 2, mask.rows - 2);
    if (corners.size() != 4 || !std::ranges::all_of(corners, [&](const auto& at) { return inside.contains(at); }))
      continue;
    best = corners;
    best_area = area;
  }
  return best;
}

// An arena brighter or darker than everything around it.
std::vector<cv::Point> by_brightness(const cv::Mat& grey) {
  std::vector<cv::Point> best;
  cv::Mat mask;
  for (const int kind : {cv::THRESH_BINARY, cv::THRESH_BINARY_INV}) {
    cv::threshold(grey, mask, 0, 255, kind | cv::THRESH_OTSU);
    // Robots and cables on the arena leave no holes in its outline.
    cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, cv::Size(9, 9)));
    const auto found = largest_quadrilateral(mask);
    if (!found.empty() && (best.empty() || cv::contourArea(found) > cv::contourArea(best))) best = found;
  }
  return best;
}

double median(const cv::Mat& part, int channel) {
  std::vector<uchar> values;
  for (int y = 0; y < part.rows; ++y)
    for (int x = 0; x < part.cols; ++x) values.push_back(part.at<cv::Vec3b>(y, x)[channel]);
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// How far each pixel's colour is from the arena's, which is that of the picture's middle and in each channel a plane:
// light falls unevenly. Medians of cells do not see the robots that stand there.
cv::Mat distance_from_table(const cv::Mat& lab) {
  constexpr int cells = 8;
  cv::Mat places(cells * cells, 3, CV_64F), colours(cells * cells, 3, CV_64F), planes;
  for (int i = 0; i < cells * cells; ++i) {
    const cv::Rect part(lab.cols / 4 + i % cells * lab.cols / 2 / cells,
                        lab.rows / 4 + i / cells * lab.rows / 2 / cells, std::max(1, lab.cols / 2 / cells),
                        std::max(1, lab.rows / 2 / cells));
    places.at<cv::Vec3d>(i, 0) = {1, part.x + part.width / 2.0, part.y + part.height / 2.0};
    for (int channel = 0; channel < 3; ++channel) colours.at<double>(i, channel) = median(lab(part), channel);
  }
  cv::solve(places, colours, planes, cv::DECOMP_SVD);
  cv::Mat distance(lab.size(), CV_32F);
  for (int y = 0; y < lab.rows; ++y)
    for (int x = 0; x < lab.cols; ++x) {
      double square = 0;
      for (int channel = 0; channel < 3; ++channel) {
        const double arena =
            planes.at<double>(0, channel) + planes.at<double>(1, channel) * x + planes.at<double>(2, channel) * y;
        square += std::pow(lab.at<cv::Vec3b>(y, x)[channel] - std::clamp(arena, 0.0, 255.0), 2);
      }
      distance.at<float>(y, x) = static_cast<float>(std::sqrt(square));
    }
  return distance;
}

// Each corner of one within a hundredth of the arena's side of a corner of the other.
bool are_near(const std::vector<cv::Point>& a, const std::vector<cv::Point>& b) {
  if (a.empty() || b.empty()) return false;
  const double near = 0.01 * std::sqrt(cv::contourArea(a));
  return std::all_of(a.begin(), a.end(), [&](const cv::Point& corner) {
    return std::any_of(b.begin(), b.end(), [&](const cv::Point& other) { return cv::norm(corner - other) < near; });
  });
}

// What has the arena's colour up to one tolerance after the other: the first outline that the next tolerance hardly
// changes.
std::vector<cv::Point> by_colour(const cv::Mat& bgr) {
  if (bgr.cols < 64 || bgr.rows < 64) return {};
  cv::Mat lab;
  cv::GaussianBlur(bgr, lab, cv::Size(5, 5), 0);
  cv::cvtColor(lab, lab, cv::COLOR_BGR2Lab);
  const cv::Mat distance = distance_from_table(lab);
  std::vector<cv::Point> before;
  for (const double tolerance : {6.0, 8.0, 10.0, 13.0, 17.0, 22.0, 30.0, 40.0}) {
    cv::Mat mask = distance < tolerance;
    cv::morphologyEx(mask, mask, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_RECT, cv::Size(3, 3)));
    cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, cv::Size(9, 9)));
    const std::vector<cv::Point> found = largest_quadrilateral(mask);
    if (are_near(found, before)) return found;
    before = found;
  }
  return {};
}

}  // namespace

std::vector<Point> find_arena_corners(const cv::Mat& picture) {
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, cv::Size(5, 5), 0);
  std::vector<cv::Point> best = by_brightness(grey);
  if (best.empty() && picture.type() == CV_8UC3) best = by_colour(picture);
  if (best.empty()) return {};
  std::vector<cv::Point2f> fine(best.begin(), best.end());
  // An outline misses corners by up to what are_near lets pass.
  const int near = std::max(5, static_cast<int>(0.02 * std::sqrt(cv::contourArea(best))));
  for (const int window : {near, 5})
    cv::cornerSubPix(grey, fine, cv::Size(window, window), cv::Size(-1, -1),
                     cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-2));
  for (std::size_t i = 0; i < 4; ++i)
    if (cv::norm(fine[i] - cv::Point2f(best[i])) > near) fine[i] = best[i];
  // Clockwise in the picture (y down), from the corner nearest to the upper left.
  std::vector<Point> corners;
  for (const cv::Point2f& at : fine) corners.push_back({at.x, at.y});
  double doubled = 0;
  for (std::size_t i = 0; i < 4; ++i)
    doubled += corners[i].x * corners[(i + 1) % 4].y - corners[(i + 1) % 4].x * corners[i].y;
  if (doubled < 0) std::reverse(corners.begin(), corners.end());
  const auto first = std::min_element(corners.begin(), corners.end(),
                                      [](const Point& a, const Point& b) { return a.x + a.y < b.x + b.y; });
  std::rotate(corners.begin(), first, corners.end());
  return corners;
}

}  // namespace arkmesh::tracker
