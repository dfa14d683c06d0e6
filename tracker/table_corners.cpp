#include "tracker/table_corners.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace arkmesh::tracker {
namespace {

constexpr double least_part = 0.1, largest_part = 0.98;  // of the picture
constexpr double straightness = 0.02;                    // of the outline's length: how far a lens may bend a side

std::vector<cv::Point> largest_quadrilateral(const cv::Mat& mask) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::vector<cv::Point> best;
  double best_area = least_part * mask.total();
  for (const auto& outline : outlines) {
    std::vector<cv::Point> hull, corners;
    cv::convexHull(outline, hull);
    const double area = cv::contourArea(hull);
    if (area <= best_area || area > largest_part * mask.total() || cv::contourArea(outline) < 0.85 * area) continue;
    cv::approxPolyDP(hull, corners, straightness * cv::arcLength(hull, true), true);
    if (corners.size() != 4) continue;
    best = corners;
    best_area = area;
  }
  return best;
}

}  // namespace

std::vector<Point> find_table_corners(const cv::Mat& picture) {
  cv::Mat grey = picture, mask;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, cv::Size(5, 5), 0);
  std::vector<cv::Point> best;
  for (const int kind : {cv::THRESH_BINARY, cv::THRESH_BINARY_INV}) {
    cv::threshold(grey, mask, 0, 255, kind | cv::THRESH_OTSU);
    // Robots and cables on the table leave no holes in its outline.
    cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, cv::Size(9, 9)));
    const auto found = largest_quadrilateral(mask);
    if (!found.empty() && (best.empty() || cv::contourArea(found) > cv::contourArea(best))) best = found;
  }
  if (best.empty()) return {};
  std::vector<cv::Point2f> fine(best.begin(), best.end());
  cv::cornerSubPix(grey, fine, cv::Size(5, 5), cv::Size(-1, -1), cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50,
      1e-2));
  for (std::size_t i = 0; i < 4; ++i)
    if (cv::norm(fine[i] - cv::Point2f(best[i])) > 5) fine[i] = best[i];
  // Clockwise in the picture (y down), from the corner nearest to the upper left.
  std::vector<Point> corners;
  for (const cv::Point2f& at : fine) corners.push_back({at.x, at.y});
  double doubled = 0;
  for (std::size_t i = 0; i < 4; ++i) doubled += corners[i].x * corners[(i + 1) % 4].y - corners[(i + 1) % 4].x * corners[i].y;
  if (doubled < 0) std::reverse(corners.begin(), corners.end());
  const auto first = std::min_element(corners.begin(), corners.end(), [](const Point& a, const Point& b) { return a.x + a.y < b.x + b.y; });
  std::rotate(corners.begin(), first, corners.end());
  return corners;
}

}  // namespace arkmesh::tracker
