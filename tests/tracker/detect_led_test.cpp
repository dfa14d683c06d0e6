// Colours of LEDs: the light by itself, and on robots whose LED is given other colours.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "tests/support/pictures/other_arenas.hpp"
#include "tests/support/pictures/photo_effects.hpp"
#include "tracker/detect/detector.hpp"
#include "tracker/detect/led_colour.hpp"
#include "tracker/detect/led_neighbours.hpp"
#include "tracker/detect/led_spot.hpp"
#include "tracker/detect/white_balance.hpp"

namespace arkmesh::tests {
namespace {

using hal::Led;

TEST_CASE("led_colour") {
  // Proves: each of the seven colours is told from the light that an LED adds, pale or rich, at any strength.
  struct Case {
    double blue, green, red;
    Led led;
  };
  for (const Case& one : {Case{20, 20, 200, Led::red},
                          {100, 100, 160, Led::red},
                          {20, 200, 20, Led::green},
                          {60, 80, 55, Led::green},
                          {200, 30, 30, Led::blue},
                          {200, 40, 100, Led::blue},
                          {20, 180, 200, Led::yellow},
                          {200, 190, 20, Led::cyan},
                          {190, 20, 200, Led::magenta},
                          {200, 200, 200, Led::white},
                          {190, 200, 195, Led::white},
                          {180, 195, 200, Led::white}})
    for (const double strength : {0.1, 1.0, 3.0}) {
      CAPTURE(one.blue);
      CAPTURE(one.green);
      CAPTURE(one.red);
      CHECK(tracker::led_colour({one.blue * strength, one.green * strength, one.red * strength}).led == one.led);
    }
}

TEST_CASE("led_colour, strange light") {
  // Proves: no light, less than none, and what is not a number give an answer without certainty rather than a colour.
  CHECK(tracker::led_colour({0, 0, 0}).confidence == 0);
  CHECK(tracker::led_colour({-5, -1, -200}).confidence == 0);
  CHECK(tracker::led_colour({NAN, NAN, NAN}).confidence == 0);
  CHECK(tracker::led_colour({-5, -1, 200}).led == Led::red);
  CHECK(tracker::led_colour({200, -3, 198}).led == Led::magenta);
}

TEST_CASE("blue and magenta beside others") {
  // Proves: two groups of hue are two colours wherever a camera sees them; a robot of an odd blue alone stays blue, and
  // other colours are not touched.
  struct Case {
    std::vector<double> hues_deg;
    std::vector<Led> wanted;
  };
  for (const Case& one :
       {Case{{230, 240, 250, 278, 282, 285},
             {Led::blue, Led::blue, Led::blue, Led::magenta, Led::magenta, Led::magenta}},
        Case{{224, 232, 241, 283}, {Led::blue, Led::blue, Led::blue, Led::blue}},
        Case{{283, 288}, {Led::magenta, Led::magenta}}, Case{{291, 299}, {Led::magenta, Led::magenta}},
        Case{{250, 260, 262, 300}, {Led::blue, Led::blue, Led::blue, Led::magenta}},
        Case{{262, 280}, {Led::blue, Led::blue}}}) {
    CAPTURE(one.hues_deg.size());
    CAPTURE(one.hues_deg.front());
    std::vector<tracker::Detection> robots;
    // the other way round, as their order does not count
    for (std::size_t i = one.hues_deg.size(); i-- > 0;)
      robots.push_back({.led = one.hues_deg[i] < 295 ? Led::blue : Led::magenta,
                        .led_confidence = 0.9F,
                        .led_lit_confidence = 1,
                        .led_hue_deg = one.hues_deg[i]});
    robots.push_back({.led = Led::red, .led_confidence = 1, .led_lit_confidence = 1, .led_hue_deg = 330});
    std::vector<tracker::Detection*> all;
    for (tracker::Detection& robot : robots) all.push_back(&robot);
    tracker::judge_beside_others(all);
    for (std::size_t i = 0; i < one.wanted.size(); ++i) CHECK(robots[one.wanted.size() - 1 - i].led == one.wanted[i]);
    CHECK(robots.back().led == Led::red);
  }
}

TEST_CASE("white must be earned") {
  // Proves: white light where lamps are mirrored is unknown, with its direction; a white LED and coloured ones stay.
  const auto robot = [](Led led, double far, double angle_rad) {
    return tracker::Detection{.r_px = 20,
                              .led = led,
                              .led_confidence = 1,
                              .led_x_px = 20 * far * std::cos(angle_rad),
                              .led_y_px = 20 * far * std::sin(angle_rad)};
  };
  struct Case {
    tracker::Detection robot;
    Led wanted;
  };
  Case cases[] = {{robot(Led::white, 0.66, 1.0), Led::unknown}, {robot(Led::white, 0.7, 1.2), Led::unknown},
                  {robot(Led::white, 0.85, 1.5), Led::unknown}, {robot(Led::white, 0.85, 2.5), Led::white},
                  {robot(Led::white, 0.94, 1.1), Led::white},   {robot(Led::green, 0.7, 1.1), Led::green}};
  std::vector<tracker::Detection*> all;
  for (Case& one : cases) all.push_back(&one.robot);
  tracker::doubt_white(all);
  for (const Case& one : cases) {
    CHECK(one.robot.led == one.wanted);
    CHECK(std::isnan(one.robot.led_x_px) == (one.wanted == Led::unknown));
    CHECK((one.robot.led_confidence > 0) == (one.wanted != Led::unknown));
  }
  // One robot alone has no direction in common with others.
  tracker::Detection alone = robot(Led::white, 0.85, 1.5), inner = robot(Led::white, 0.7, 1.5);
  all = {&alone, &inner};
  tracker::doubt_white(all);
  CHECK(alone.led == Led::white);
  CHECK(inner.led == Led::unknown);
}

TEST_CASE("a grey picture's LEDs are unknown") {
  // Proves: what a monochrome camera cannot show is not guessed, in searches and while following.
  const Scene grey = changed(real_scenes()[2], [](cv::Mat& m) {
    cv::cvtColor(m, m, cv::COLOR_BGR2GRAY), cv::cvtColor(m, m, cv::COLOR_GRAY2BGR);
  });
  tracker::Detector detector;
  const auto found = detector.search(grey.bgr);
  CHECK(found.size() == 28);
  std::vector<tracker::Expected> where;
  for (const tracker::Detection& one : found) {
    CHECK(one.led == Led::unknown);
    CHECK(std::isnan(one.led_x_px));
    where.push_back({one.x_px, one.y_px, one.r_px, one.r_px / 2});
  }
  for (const auto& one : detector.follow(grey.bgr, where))
    if (one) CHECK(one->led == Led::unknown);
}

TEST_CASE("find_led, all colours") {
  // Proves: on real robots whose blue light is given another colour, that colour is seen, and the core is where it was.
  const std::vector<Scene> scenes = real_scenes();
  for (const Led led : {Led::red, Led::green, Led::blue, Led::magenta, Led::cyan, Led::yellow, Led::white}) {
    int right = 0, all = 0;
    for (const Scene& scene : scenes)
      for (const Scene coloured = recoloured(scene, led); const TrueRobot& robot : scene.robots) {
        if (robot.led != Led::blue) continue;
        const tracker::LedSpot spot = tracker::find_led(coloured.bgr, {robot.x_px, robot.y_px, robot.r_px});
        ++all;
        if (spot.led == led && std::hypot(spot.x_px - robot.led_x_px, spot.y_px - robot.led_y_px) < 0.2 * robot.r_px)
          ++right;
      }
    CAPTURE(static_cast<int>(led));
    CHECK(all == 51);
    CHECK(right >= 0.88 * all);
  }
}

TEST_CASE("find_led, glare on the coin cell") {
  // Proves: a lit LED is lit beside a coin cell that mirrors a lamp, and no unlit one is because of it.
  int lit = 0, all = 0, wrong = 0;
  for (const Scene& scene : real_scenes())
    for (const double levels : {60.0, 90.0, 120.0})
      for (const Scene glaring = with_glare(scene, levels); const TrueRobot& robot : glaring.robots) {
        const Led led = tracker::find_led(glaring.bgr, {robot.x_px, robot.y_px, robot.r_px}).led;
        if (robot.led == Led::off)
          wrong += led != Led::off;
        else
          ++all, lit += led != Led::off;
      }
  CHECK(all == 351);
  CHECK(lit >= 0.95 * all);
  CHECK(wrong <= 3);
}

TEST_CASE("find_led, light where no LED can be") {
  // Proves: bright red light on a robot is its LED at 0.86 of the radius, and unknown nearer to the centre or outside.
  for (const double part : {0.64, 0.86, 1.14}) {
    const Led led = part == 0.86 ? Led::red : Led::unknown;
    cv::Mat bgr(120, 120, CV_8UC3, cv::Scalar::all(110));
    cv::circle(bgr, {60, 60}, 40, cv::Scalar::all(30), -1);
    cv::circle(bgr, {60, 60}, 22, cv::Scalar::all(90), -1);
    cv::circle(bgr, {60 + static_cast<int>(std::lround(40 * part)), 60}, 8, {60, 60, 255}, -1);
    const tracker::LedSpot spot = tracker::find_led(bgr, {60, 60, 40});
    CAPTURE(part);
    CHECK(spot.led == led);
    CHECK(std::isnan(spot.x_px) == (led == Led::unknown));
  }
}

TEST_CASE("find_led, a saturated middle") {
  // Proves: the halo decides, as webcams see the saturated middle of a green LED cyan.
  cv::Mat bgr(120, 120, CV_8UC3, cv::Scalar(170, 170, 170));
  cv::circle(bgr, {60, 60}, 40, {30, 30, 30}, cv::FILLED);
  cv::circle(bgr, {60, 60}, 26, {110, 110, 110}, cv::FILLED);
  cv::circle(bgr, {94, 60}, 13, {45, 115, 30}, cv::FILLED);
  cv::circle(bgr, {94, 60}, 6, {255, 255, 60}, cv::FILLED);
  CHECK(tracker::find_led(bgr, {60, 60, 40}).led == Led::green);
}

TEST_CASE("find_led, casts, haze and white arenas") {
  // Proves: what light and arena do to a whole picture is taken out: of lit LEDs that are called anything, nearly all
  // have the right colour, and hardly an unlit one is lit.
  struct Case {
    const char* name;
    double least;
    std::function<Scene(const Scene&)> make;
  };
  const auto pixels = [](const std::function<void(cv::Mat&)>& change) {
    return [=](const Scene& scene) { return changed(scene, change); };
  };
  for (const Case& one : {Case{"warm", 0.9, pixels([](cv::Mat& m) { cast(m, 0.65, 0.95, 1.25); })},
                          {"cool", 0.9, pixels([](cv::Mat& m) { cast(m, 1.3, 1.0, 0.75); })},
                          {"greenish", 0.9, pixels([](cv::Mat& m) { cast(m, 0.8, 1.15, 0.85); })},
                          {"pink", 0.9, pixels([](cv::Mat& m) { cast(m, 1.1, 0.8, 1.15); })},
                          {"hazy", 0.9, pixels([](cv::Mat& m) { m.convertTo(m, -1, 0.25, 90); })},
                          {"white arena", 0.95, [](const Scene& scene) { return on_arena(scene, "white"); }}}) {
    int lit = 0, told = 0, right = 0, unlit_lit = 0;
    for (const Scene& real : real_scenes()) {
      const Scene scene = one.make(real);
      std::vector<tracker::Circle> boards;
      for (const TrueRobot& robot : scene.robots) boards.push_back({robot.x_px, robot.y_px, robot.r_px});
      const tracker::Light gains = tracker::white_balance(scene.bgr, boards);
      for (std::size_t i = 0; i < boards.size(); ++i) {
        const Led led = tracker::find_led(scene.bgr, boards[i], gains).led, truth = scene.robots[i].led;
        if (truth == Led::off)
          unlit_lit += led != Led::off && led != Led::unknown;
        else
          ++lit, told += led != Led::unknown, right += led == truth;
      }
    }
    CAPTURE(one.name);
    CHECK(lit == 117);
    CHECK(right >= one.least * told);
    CHECK(told >= 0.7 * lit);
    CHECK(unlit_lit <= 2);
  }
}

TEST_CASE("find_led, unlit and out of sight") {
  // Proves: glints on unlit robots are no LEDs, and places outside the picture are looked at without harm.
  const Scene unlit = real_scenes()[1];
  int lit = 0;
  for (const TrueRobot& robot : unlit.robots)
    if (tracker::find_led(unlit.bgr, {robot.x_px, robot.y_px, robot.r_px}).led != Led::off) ++lit;
  CHECK(lit <= 1);
  for (const tracker::Circle& circle :
       {tracker::Circle{-500, -500, 20}, {5, 5, 400}, {0, 0, 2}, {100, 100, 0}, {100, 100, NAN}}) {
    const tracker::LedSpot spot = tracker::find_led(unlit.bgr, circle);
    CHECK((spot.led != Led::off || std::isnan(spot.x_px)));
  }
}

}  // namespace
}  // namespace arkmesh::tests
