// See clutter.hpp.
#include "tests/support/pictures/clutter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>

namespace arkmesh::tests {
namespace {

constexpr double tau = 2 * std::numbers::pi;

// Draws on a layer, mixed with the picture by what covers it.
class Brush {
 public:
  Brush(cv::Mat& bgr, unsigned seed) : bgr_(bgr), random_(seed) {}
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  double from_to(double a, double b) { return a + (b - a) * unit(); }

  void disc(cv::Point2d at, double r, const cv::Scalar& colour) {
    cv::circle(bgr_, fine(at), fine(r), colour, cv::FILLED, cv::LINE_AA, 4);
  }
  void ring(cv::Point2d at, double r, double width, const cv::Scalar& colour) {
    cv::circle(bgr_, fine(at), fine(r), colour, std::max(1, static_cast<int>(std::lround(width))), cv::LINE_AA, 4);
  }
  void line(cv::Point2d from, cv::Point2d to, double width, const cv::Scalar& colour) {
    cv::line(bgr_, fine(from), fine(to), colour, std::max(1, static_cast<int>(std::lround(width))), cv::LINE_AA, 4);
  }
  void shape(const std::vector<cv::Point2d>& corners, const cv::Scalar& colour) {
    std::vector<cv::Point> points;
    for (const cv::Point2d& one : corners) points.push_back(fine(one));
    cv::fillPoly(bgr_, std::vector<std::vector<cv::Point>>{points}, colour, cv::LINE_AA, 4);
  }
  // A soft shadow or glow: the picture times, or plus, a bell.
  void soft(cv::Point2d at, double r, const cv::Vec3d& times, const cv::Vec3d& plus) {
    const int reach = static_cast<int>(2 * r) + 1;
    for (int y = std::max(0, static_cast<int>(at.y) - reach); y < std::min(bgr_.rows, static_cast<int>(at.y) + reach);
         ++y)
      for (int x = std::max(0, static_cast<int>(at.x) - reach); x < std::min(bgr_.cols, static_cast<int>(at.x) + reach);
           ++x) {
        const double bell = std::exp(-1.5 * ((x - at.x) * (x - at.x) + (y - at.y) * (y - at.y)) / (r * r));
        cv::Vec3b& pixel = bgr_.at<cv::Vec3b>(y, x);
        for (int c = 0; c < 3; ++c)
          pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] * (1 + (times[c] - 1) * bell) + plus[c] * bell);
      }
  }
  void words(cv::Point2d at, double size) {
    static const char* const all[] = {"Kilobot", "42 mm", "OO8O", "exp. 7", "do not move"};
    cv::putText(bgr_, all[random_() % 5], at, cv::FONT_HERSHEY_SIMPLEX, size / 22, cv::Scalar::all(40),
                std::max(1, static_cast<int>(size / 11)), cv::LINE_AA);
  }

 private:
  static cv::Point fine(cv::Point2d at) {
    return {static_cast<int>(std::lround(at.x * 16)), static_cast<int>(std::lround(at.y * 16))};
  }
  static int fine(double r) { return static_cast<int>(std::lround(r * 16)); }
  cv::Mat& bgr_;
  std::mt19937 random_;
};

void coin(Brush& brush, cv::Point2d at, double r_px) {
  const cv::Scalar metals[] = {{90, 120, 175}, {95, 150, 185}, {165, 168, 170}};
  const cv::Scalar metal = metals[static_cast<int>(brush.unit() * 2.999)];
  const double r = r_px * brush.from_to(0.5, 0.8);
  brush.soft(at + cv::Point2d(0.1, 0.1) * r, r, {0.7, 0.7, 0.7}, {});
  brush.disc(at, r, metal * 0.75);
  brush.disc(at, 0.9 * r, metal);
  for (int i = 0; i < 9; ++i)
    brush.line(at + cv::Point2d(brush.from_to(-0.5, 0.5), brush.from_to(-0.5, 0.5)) * r,
               at + cv::Point2d(brush.from_to(-0.5, 0.5), brush.from_to(-0.5, 0.5)) * r, 0.1 * r,
               metal * brush.from_to(0.7, 1.2));
}

void cap(Brush& brush, cv::Point2d at, double r_px) {
  const double r = r_px * brush.from_to(0.8, 1.0);
  const cv::Scalar paint(brush.from_to(20, 220), brush.from_to(20, 220), brush.from_to(20, 220));
  brush.soft(at + cv::Point2d(0.15, 0.15) * r, r, {0.6, 0.6, 0.6}, {});
  std::vector<cv::Point2d> crown;
  for (int i = 0; i < 42; ++i)
    crown.push_back(at + cv::Point2d(std::cos(i * tau / 42), std::sin(i * tau / 42)) * (i % 2 ? 0.92 * r : r));
  brush.shape(crown, paint * 0.7);
  brush.disc(at, 0.8 * r, paint);
  brush.soft(at - cv::Point2d(0.3, 0.3) * r, 0.25 * r, {1, 1, 1}, {70, 70, 70});
  brush.words(at - cv::Point2d(0.6, -0.15) * r, 0.35 * r);
}

void screw(Brush& brush, cv::Point2d at, double r_px) {
  const double r = r_px * brush.from_to(0.18, 0.35), angle = brush.unit() * tau;
  const cv::Point2d along(std::cos(angle), std::sin(angle)), across(-along.y, along.x);
  brush.line(at, at + along * (5 * r), r, cv::Scalar::all(110));
  brush.disc(at, r, cv::Scalar::all(170));
  brush.line(at - along * (0.7 * r), at + along * (0.7 * r), 0.3 * r, cv::Scalar::all(50));
  brush.line(at - across * (0.7 * r), at + across * (0.7 * r), 0.3 * r, cv::Scalar::all(50));
}

void led(Brush& brush, cv::Point2d at, double r_px) {
  cv::Vec3d light;
  const int bits = 1 + static_cast<int>(brush.unit() * 6.999);
  for (int c = 0; c < 3; ++c) light[c] = bits >> c & 1 ? 230 : 20;
  brush.soft(at, 0.5 * r_px, {1, 1, 1}, light);
  brush.disc(at, 0.15 * r_px, cv::Scalar::all(255));
}

void clip(Brush& brush, cv::Point2d at, double r_px) {
  const double angle = brush.unit() * tau, wide = 0.28 * r_px;
  const cv::Point2d along(std::cos(angle), std::sin(angle)), across(-along.y, along.x);
  for (int bend = 0; bend < 3; ++bend) {
    const double length = (0.95 - 0.2 * bend) * r_px, half = wide * (1 - 0.25 * bend);
    brush.line(at + across * half - along * length, at + across * half + along * length, 0.08 * r_px,
               cv::Scalar::all(150));
    brush.line(at - across * half - along * length, at - across * half + along * length, 0.08 * r_px,
               cv::Scalar::all(150));
    for (int i = 0; i < 8; ++i) {
      const double a = i * tau / 16 - tau / 4, b = (i + 1) * tau / 16 - tau / 4;
      brush.line(at + along * (length + half * std::cos(a)) + across * (half * std::sin(a)),
                 at + along * (length + half * std::cos(b)) + across * (half * std::sin(b)), 0.08 * r_px,
                 cv::Scalar::all(150));
    }
  }
}

void cable(Brush& brush, cv::Point2d at, double r_px) {
  double angle = brush.unit() * tau, bend = 0;
  const double width = r_px * brush.from_to(0.12, 0.5);
  const cv::Scalar colour = cv::Scalar::all(brush.from_to(15, 60));
  for (int i = 0; i < 14; ++i) {
    const cv::Point2d next = at + cv::Point2d(std::cos(angle), std::sin(angle)) * (0.4 * r_px);
    brush.line(at, next, width, colour);
    at = next;
    bend = std::clamp(bend + brush.from_to(-0.3, 0.3), -0.45, 0.45);
    angle += bend;
  }
}

void hand(Brush& brush, cv::Point2d at, double r_px) {
  const double angle = brush.unit() * tau;
  const cv::Scalar skin(120, 150, 205);
  brush.soft(at, 4 * r_px, {0.8, 0.8, 0.8}, {});
  brush.disc(at, 2.2 * r_px, skin);
  for (int finger = 0; finger < 5; ++finger) {
    const double to = angle + (finger - 2) * 0.42;
    const cv::Point2d tip = at + cv::Point2d(std::cos(to), std::sin(to)) * (4.2 * r_px);
    brush.line(at, tip, 0.95 * r_px, skin * (0.9 + 0.04 * finger));
    brush.disc(tip - cv::Point2d(std::cos(to), std::sin(to)) * (0.1 * r_px), 0.25 * r_px, skin * 1.15);
  }
}

// The edge of a circuit board: holes in pads of gold.
void pads(Brush& brush, cv::Point2d at, double r_px) {
  const double angle = brush.unit() * tau;
  const cv::Point2d along(std::cos(angle), std::sin(angle)), across(-along.y, along.x);
  const cv::Point2d far = along * (6.2 * r_px), wide = across * (2.2 * r_px);
  brush.shape({at - far - wide, at + far - wide, at + far + wide, at - far + wide}, cv::Scalar(45, 40, 40));
  for (int hole = -1; hole <= 1; ++hole) {
    const cv::Point2d middle = at + along * (4 * hole * r_px);
    brush.disc(middle, 1.45 * r_px, cv::Scalar(140, 200, 225));
    brush.disc(middle, r_px, cv::Scalar::all(50));
    brush.disc(middle, 0.75 * r_px, cv::Scalar::all(110));
    for (int speck = 0; speck < 12; ++speck) {
      const cv::Point2d to(brush.from_to(-0.6, 0.6), brush.from_to(-0.6, 0.6));
      brush.disc(middle + to * r_px, 0.12 * r_px, cv::Scalar::all(brush.from_to(40, 150)));
    }
  }
}

void draw(Brush& brush, const std::string& kind, cv::Point2d at, double r_px) {
  const auto any_size = [&] { return r_px * (brush.unit() < 0.3 ? 1.0 : brush.from_to(0.4, 1.6)); };
  if (kind == "black discs")
    brush.disc(at, any_size(), cv::Scalar::all(brush.from_to(10, 40)));
  else if (kind == "white discs") {
    const double r = any_size();
    brush.soft(at + cv::Point2d(0.15, 0.15) * r, 1.1 * r, {0.6, 0.6, 0.6}, {}),
        brush.disc(at, r, cv::Scalar::all(brush.from_to(225, 255)));
  } else if (kind == "grey discs")
    brush.disc(at, any_size(), cv::Scalar(brush.from_to(60, 140), brush.from_to(60, 140), brush.from_to(60, 140)));
  else if (kind == "coins")
    coin(brush, at, r_px);
  else if (kind == "caps")
    cap(brush, at, r_px);
  else if (kind == "rings") {
    brush.ring(at, r_px * brush.from_to(0.4, 1.2), r_px * brush.from_to(0.1, 0.35),
               cv::Scalar::all(brush.unit() < 0.5 ? 30 : 140));
  } else if (kind == "screws")
    screw(brush, at, r_px);
  else if (kind == "LEDs")
    led(brush, at, r_px);
  else if (kind == "clips")
    clip(brush, at, r_px);
  else if (kind == "tape") {
    const double angle = brush.unit() * tau;
    const cv::Scalar colours[] = {cv::Scalar::all(30), {60, 200, 220}, cv::Scalar::all(240)};
    brush.line(at, at + cv::Point2d(std::cos(angle), std::sin(angle)) * (6 * r_px), 1.1 * r_px,
               colours[static_cast<int>(brush.unit() * 2.999)]);
  } else if (kind == "cables")
    cable(brush, at, r_px);
  else if (kind == "hands")
    hand(brush, at, r_px);
  else if (kind == "cups") {
    const double r = r_px * brush.from_to(1.5, 2.6);
    brush.disc(at, r, cv::Scalar(200, 205, 210)), brush.ring(at, 0.95 * r, 0.12 * r, cv::Scalar::all(235)),
        brush.disc(at, 0.85 * r, cv::Scalar(25, 45, 70));
  } else if (kind == "words")
    brush.words(at, r_px);
  else if (kind == "pads")
    pads(brush, at, r_px);
  else if (kind == "lamps")
    brush.soft(at, r_px * brush.from_to(0.5, 4), {1, 1, 1}, cv::Vec3d::all(brush.from_to(60, 200)));
  else
    throw std::runtime_error("no clutter is called " + kind);
}

// How far a thing reaches from where it is drawn, in radii of robots.
double reach_of(const std::string& kind) {
  if (kind == "tape" || kind == "cables") return 7;
  if (kind == "hands") return 5;
  if (kind == "words" || kind == "pads") return 7;
  return kind == "cups" || kind == "lamps" || kind == "screws" ? 3 : 2;
}

}  // namespace

const std::vector<std::string>& clutter_kinds() {
  static const std::vector<std::string> kinds = {"black discs", "white discs", "grey discs", "coins", "caps",   "rings",
                                                 "screws",      "LEDs",        "clips",      "tape",  "cables", "hands",
                                                 "cups",        "words",       "lamps",      "pads"};
  return kinds;
}

Scene with_clutter(const Scene& scene, const std::string& kind, int count, double robot_px, unsigned seed) {
  Scene out{scene.name + " and " + kind, scene.bgr.clone(), scene.robots, scene.also};
  Brush brush(out.bgr, seed);
  const double r_px = robot_px / 2;
  std::vector<cv::Point2d> things;
  for (int tries = 0; static_cast<int>(things.size()) < count && tries < 3000; ++tries) {
    const cv::Point2d at(brush.unit() * scene.bgr.cols, brush.unit() * scene.bgr.rows);
    const double reach = r_px * reach_of(kind);
    if (std::any_of(out.robots.begin(), out.robots.end(), [&](const TrueRobot& robot) {
          return std::hypot(robot.x_px - at.x, robot.y_px - at.y) < reach + 1.05 * robot.r_px;
        }))
      continue;
    if (std::any_of(things.begin(), things.end(),
                    [&](const cv::Point2d& other) { return cv::norm(other - at) < 1.3 * reach; }))
      continue;
    draw(brush, kind, at, r_px);
    things.push_back(at);
  }
  cv::Mat soft;
  cv::GaussianBlur(out.bgr, soft, {}, 0.6);
  // sharp robots stay as they are
  cv::Mat changed, mask;
  cv::absdiff(out.bgr, scene.bgr, changed);
  cv::cvtColor(changed, mask, cv::COLOR_BGR2GRAY);
  cv::dilate(mask, mask, cv::Mat::ones(5, 5, CV_8U));
  soft.copyTo(out.bgr, mask > 0);
  return out;
}

}  // namespace arkmesh::tests
