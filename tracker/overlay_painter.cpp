#include "tracker/overlay_painter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tracker/brush.hpp"

namespace arkmesh::tracker {
namespace {

using Stroke = std::vector<cv::Point>;  // with fine_shift
using Spots = std::vector<hal::Point>;

cv::Vec3b overlay_bgr(hal::Colour colour) {
  const std::uint32_t rgb = hal::look_of(colour).dark;
  const auto part = [&](int bits) { return static_cast<unsigned char>(rgb >> bits & 0xff); };
  return {part(0), part(8), part(16)};
}

Spots circle_places(const hal::Circle& circle) {
  constexpr int steps = 48;
  Spots out;
  for (int i = 0; i < steps; ++i) {
    const double angle = 2 * std::numbers::pi * i / steps;
    out.push_back(
        {circle.at.x_m + circle.radius_m * std::cos(angle), circle.at.y_m + circle.radius_m * std::sin(angle)});
  }
  return out;
}

// Where the corner of a raster's cell is in the arena.
hal::Point cell_corner(const hal::Raster& raster, std::size_t column, std::size_t row) {
  const double c = std::cos(raster.corner.heading_rad), s = std::sin(raster.corner.heading_rad);
  const double along = static_cast<double>(column) * raster.cell_m, left = static_cast<double>(row) * raster.cell_m;
  return {raster.corner.x_m + c * along - s * left, raster.corner.y_m + s * along + c * left};
}

class Painter {
 public:
  Painter(cv::Mat& picture, const Calibration& camera)
      : picture_(picture),
        camera_(camera),
        frame_({}, picture.size()),
        label_px_(std::clamp(picture.rows / 32.0, 12.0, 32.0)),
        pattern_px_(std::max(6, picture.rows / 90)),
        thick_px_(picture.rows < 500 ? 1 : 2),
        fill_left_px_(most_pictures * picture.rows * picture.cols) {}

  void fill(const Spots& places, hal::Colour colour) {
    Stroke outline;
    for (const auto& at : path(places, true))
      if (at) outline.push_back(*at);
    if (outline.size() < 3) return;
    const cv::Rect box = box_of(outline);
    if (box.empty() || (fill_left_px_ -= box.area()) < 0) return;
    for (cv::Point& at : outline) at -= box.tl() * (1 << fine_shift);
    cv::Mat opacity = cv::Mat::zeros(box.size(), CV_8UC1);
    cv::fillPoly(opacity, std::vector<Stroke>{outline}, cv::Scalar(255 * hal::fill_opacity), cv::LINE_8, fine_shift);
    blend(box, opacity, colour, hal::look_of(colour).pattern);
  }

  void stroke(const Spots& places, bool closed, bool dashed, hal::Colour colour) {
    const cv::Scalar ink(overlay_bgr(colour));
    const auto points = path(places, closed);
    double along_px = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
      if (!points[i - 1] || !points[i]) continue;
      const cv::Point step = *points[i] - *points[i - 1];
      const double length_px = std::hypot(step.x, step.y) / (1 << fine_shift);
      if ((stroke_left_px_ -= std::min<double>(length_px, frame_.width + frame_.height)) < 0) return;
      if (!dashed)
        cv::line(picture_, *points[i - 1], *points[i], ink, thick_px_, cv::LINE_AA, fine_shift);
      else
        along_px = dash(*points[i - 1], *points[i], along_px, ink);
    }
  }

  void raster(const hal::Raster& raster) {
    const auto columns = static_cast<std::size_t>(raster.columns), rows = raster.cells.size() / columns;
    std::vector<std::optional<cv::Point>> corners;
    Stroke seen;
    for (std::size_t row = 0; row <= rows; ++row)
      for (std::size_t column = 0; column <= columns; ++column)
        if (corners.push_back(pixel(cell_corner(raster, column, row))); corners.back()) seen.push_back(*corners.back());
    if (seen.empty()) return;
    const cv::Rect box = box_of(seen);
    if (box.empty() || (fill_left_px_ -= box.area()) < 0) return;
    cv::Mat opacity = cv::Mat::zeros(box.size(), CV_8UC1);
    for (std::size_t cell = 0; cell < raster.cells.size(); ++cell) {
      if (raster.cells[cell] == 0) continue;
      const std::size_t first = cell / columns * (columns + 1) + cell % columns, above = first + columns + 1;
      cv::Point quad[4];
      std::size_t known = 0;
      for (std::size_t corner : {first, first + 1, above + 1, above})
        if (corners[corner]) quad[known++] = *corners[corner] - box.tl() * (1 << fine_shift);
      if (known == 4)
        cv::fillConvexPoly(opacity, quad, 4, cv::Scalar(raster.cells[cell] * hal::raster_opacity), cv::LINE_8,
                           fine_shift);
    }
    blend(box, opacity, raster.colour, hal::Pattern::plain);
  }

  // Above the highest of some places in the picture.
  void label_above(const Spots& places, const std::string& words, hal::Colour colour) {
    if (words.empty()) return;
    Stroke seen;
    for (const hal::Point& place : places)
      if (const auto at = pixel(place)) seen.push_back(*at);
    if (seen.empty()) return;
    const double unit = 1 << fine_shift;
    double left = seen[0].x, right = seen[0].x, top = seen[0].y;
    for (const cv::Point& at : seen)
      left = std::min<double>(left, at.x), right = std::max<double>(right, at.x), top = std::min<double>(top, at.y);
    words_at({(left + right) / 2 / unit, top / unit - 0.6 * label_px_}, words, colour);
  }
  void label_at(const hal::Point& place, const std::string& words, hal::Colour colour) {
    if (words.empty()) return;
    if (const auto at = camera_.to_pixel({place.x_m, place.y_m}, 0)) words_at(*at, words, colour);
  }

 private:
  std::optional<cv::Point> pixel(const hal::Point& place) const {
    return fine(camera_.to_pixel({place.x_m, place.y_m}, 0));
  }

  // The way through these places as the camera sees it: lenses bend long lines. Holes where it cannot look.
  std::vector<std::optional<cv::Point>> path(const Spots& places, bool closed) const {
    const double straight_m = std::max(camera_.data().arena_width_m, camera_.data().arena_height_m) / 32;
    std::vector<std::optional<cv::Point>> out;
    if (!places.empty()) out.push_back(pixel(places[0]));
    for (std::size_t i = 1; i < places.size() + closed; ++i) {
      const hal::Point &from = places[i - 1], &to = places[i % places.size()];
      const double length_m = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
      const int pieces = static_cast<int>(std::clamp(std::ceil(length_m / straight_m), 1.0, 64.0));
      for (int k = 1; k <= pieces; ++k) {
        const double part = static_cast<double>(k) / pieces;
        out.push_back(pixel({from.x_m + (to.x_m - from.x_m) * part, from.y_m + (to.y_m - from.y_m) * part}));
      }
    }
    return out;
  }

  // The pixels of the picture that these points enclose.
  cv::Rect box_of(const Stroke& points) const {
    const cv::Rect box = cv::boundingRect(points);
    const cv::Point first(box.x >> fine_shift, box.y >> fine_shift);
    const cv::Point last((box.br().x >> fine_shift) + 2, (box.br().y >> fine_shift) + 2);
    return cv::Rect(first, last) & frame_;
  }

  // From where a dashed line has come so far; returns where it comes to.
  double dash(cv::Point from, cv::Point to, double along_px, const cv::Scalar& ink) {
    const double unit = 1 << fine_shift, on_px = pattern_px_, step_px = 2 * on_px;
    const double whole_px = std::hypot(to.x - from.x, to.y - from.y) / unit;
    cv::Point begin = from, end = to;
    const cv::Rect fine_frame(frame_.tl() * (1 << fine_shift), frame_.size() * (1 << fine_shift));
    if (whole_px > 0 && cv::clipLine(fine_frame, begin, end)) {
      const double first_px = std::hypot(begin.x - from.x, begin.y - from.y) / unit;
      const double last_px = std::hypot(end.x - from.x, end.y - from.y) / unit;
      const auto at = [&](double px) {
        return cv::Point(from.x + static_cast<int>(std::lround((to.x - from.x) * px / whole_px)),
                         from.y + static_cast<int>(std::lround((to.y - from.y) * px / whole_px)));
      };
      for (double start = std::floor((along_px + first_px) / step_px) * step_px - along_px; start < last_px;
           start += step_px) {
        const double on = std::max(start, first_px), off = std::min(start + on_px, last_px);
        if (on < off) cv::line(picture_, at(on), at(off), ink, thick_px_, cv::LINE_AA, fine_shift);
      }
    }
    return along_px + whole_px;
  }

  bool is_pattern(hal::Pattern pattern, int x, int y) const {
    const int step = pattern_px_, thin = step > 8 ? 2 : 1;
    const bool rising = (x + y) % step < thin, falling = (x - y + picture_.rows / step * step + step) % step < thin;
    switch (pattern) {
      case hal::Pattern::plain:
        return false;
      case hal::Pattern::stripes:
        return rising;
      case hal::Pattern::dots:
        return x % step < 2 * thin && y % step < 2 * thin;
      case hal::Pattern::cross:
        return rising || falling;
    }
    return false;
  }

  void blend(const cv::Rect& box, const cv::Mat& opacity, hal::Colour colour, hal::Pattern pattern) {
    const cv::Vec3b ink = overlay_bgr(colour);
    const bool plain = pattern == hal::Pattern::plain;
    for (int y = 0; y < box.height; ++y) {
      const unsigned char* cover = opacity.ptr<unsigned char>(y);
      auto* pixels = picture_.ptr<cv::Vec3b>(box.y + y) + box.x;
      for (int x = 0; x < box.width; ++x) {
        if (cover[x] == 0) continue;
        const int part = !plain && is_pattern(pattern, box.x + x, box.y + y) ? 255 : cover[x];
        for (int channel = 0; channel < 3; ++channel)
          pixels[x][channel] =
              static_cast<unsigned char>((pixels[x][channel] * (255 - part) + ink[channel] * part) / 255);
      }
    }
  }

  void words_at(Point at, const std::string& words, hal::Colour colour) {
    constexpr double far_px = 1e5;
    if (!(std::abs(at.x) < far_px && std::abs(at.y) < far_px)) return;
    write_centred(picture_, words, at, label_px_, cv::Scalar(overlay_bgr(colour)));
  }

  // A drawing that asks for more is drawn in part, so that it cannot hold up who shows pictures: about 0.1 s.
  static constexpr double most_pictures = 16, most_stroke_px = 1e6;

  cv::Mat& picture_;
  const Calibration& camera_;
  cv::Rect frame_;
  double label_px_;
  int pattern_px_, thick_px_;
  double fill_left_px_, stroke_left_px_ = most_stroke_px;
};

hal::Point mean_of(const Spots& places) {
  hal::Point sum;
  for (const hal::Point& place : places) sum.x_m += place.x_m, sum.y_m += place.y_m;
  return {sum.x_m / static_cast<double>(places.size()), sum.y_m / static_cast<double>(places.size())};
}

}  // namespace

void draw_overlay(cv::Mat& picture, const Calibration& camera, const hal::Drawing& drawing) {
  Painter painter(picture, camera);
  for (const hal::Raster& raster : drawing.rasters()) painter.raster(raster);
  for (const hal::Polygon& polygon : drawing.polygons()) {
    if (polygon.filled) painter.fill(polygon.corners, polygon.colour);
    painter.stroke(polygon.corners, true, polygon.dashed, polygon.colour);
  }
  for (const hal::Circle& circle : drawing.circles()) {
    const Spots places = circle_places(circle);
    if (circle.filled) painter.fill(places, circle.colour);
    painter.stroke(places, true, circle.dashed, circle.colour);
  }
  for (const hal::Line& line : drawing.lines()) painter.stroke(line.points, false, line.dashed, line.colour);
  // Words last, so that nothing covers them.
  for (const hal::Raster& raster : drawing.rasters()) {
    const auto columns = static_cast<std::size_t>(raster.columns), rows = raster.cells.size() / columns;
    painter.label_above({cell_corner(raster, 0, 0), cell_corner(raster, columns, 0), cell_corner(raster, columns, rows),
                         cell_corner(raster, 0, rows)},
                        raster.label, raster.colour);
  }
  for (const hal::Polygon& polygon : drawing.polygons())
    painter.label_at(mean_of(polygon.corners), polygon.label, polygon.colour);
  for (const hal::Circle& circle : drawing.circles())
    painter.label_above(circle_places(circle), circle.label, circle.colour);
  for (const hal::Line& line : drawing.lines())
    painter.label_at(line.points[line.points.size() / 2], line.label, line.colour);
  for (const hal::Text& text : drawing.texts()) painter.label_at(text.at, text.text, text.colour);
}

}  // namespace arkmesh::tracker
