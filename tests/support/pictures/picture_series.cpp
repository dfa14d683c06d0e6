// See picture_series.hpp.
#include "tests/support/pictures/picture_series.hpp"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "tests/support/pictures/clutter.hpp"
#include "tests/support/pictures/collage.hpp"
#include "tests/support/pictures/other_arenas.hpp"
#include "tests/support/pictures/photo_effects.hpp"

namespace arkmesh::tests {
namespace {

using Scenes = std::vector<Scene>;

class Rows {
 public:
  explicit Rows(const Scenes& real) : real_(real) {}

  void group(std::string name) { group_ = std::move(name); }
  void scenes(std::string name, std::function<Scenes()> make, bool keeps_colours = true) {
    rows.push_back({group_, std::move(name), std::move(make), keeps_colours});
  }
  void each(std::string name, const std::function<Scene(const Scene&)>& change, bool keeps_colours = true) {
    scenes(
        std::move(name),
        [real = real_, change] {
          Scenes list;
          for (const Scene& scene : real) list.push_back(change(scene));
          return list;
        },
        keeps_colours);
  }
  void pixels(std::string name, const std::function<void(cv::Mat&)>& change, bool keeps_colours = true) {
    each(
        std::move(name), [change](const Scene& scene) { return changed(scene, change); }, keeps_colours);
  }

  std::vector<PictureSeries> rows;

 private:
  const Scenes& real_;
  std::string group_;
};

Scenes in_diameters(const Scenes& scenes, const std::vector<double>& diameters_px) {
  Scenes list;
  for (const Scene& scene : scenes)
    for (const double diameter_px : diameters_px) list.push_back(with_diameter(scene, diameter_px));
  return list;
}

Scenes emptied_all(const Scenes& real, double factor) {
  Scenes list;
  for (const Scene& scene : real) list.push_back(resized(emptied(scene), factor));
  return list;
}

void sizes(Rows& rows) {
  rows.group("size");
  for (const double diameter_px : {12.0, 13.0, 14.0, 16.0, 18.0, 20.0, 24.0, 28.0, 36.0, 48.0, 60.0, 72.0, 100.0})
    rows.each(fmt::format("{} px across", diameter_px),
              [=](const Scene& scene) { return with_diameter(scene, diameter_px); });
}

void views(Rows& rows, const Scenes& real) {
  rows.group("view");
  for (const double angle_deg : {10.0, 45.0, 90.0, 115.0, 200.0}) {
    rows.each(fmt::format("turned {} deg", angle_deg),
              [=](const Scene& scene) { return turned(scene, angle_deg, false); });
    rows.each(fmt::format("turned {} deg, black corners", angle_deg),
              [=](const Scene& scene) { return turned(scene, angle_deg, true); });
  }
  rows.each("mirrored", mirrored);
  rows.each("seen at an angle", [](const Scene& scene) {
    const cv::Size size = scene.bgr.size();
    return warped(scene, cv::Matx33d(1, 0, 0, 0, 1, 0, 0.12 / size.width, 0.08 / size.height, 1), size);
  });
  rows.group("cut out");
  for (const int robots : {1, 2, 3, 5}) {
    const std::string name = fmt::format("{} robot{}", robots, robots == 1 ? "" : "s");
    rows.scenes(name, [=, &real] { return cut_outs(real, robots, 30, 1); });
    for (const double diameter_px : {12.0, 20.0, 30.0})
      rows.scenes(fmt::format("{}, {} px", name, diameter_px),
                  [=, &real] { return cut_outs(in_diameters(real, {diameter_px}), robots, 30, 2); });
  }
  for (const double part : {1.0, 0.8, 0.65})
    rows.scenes(fmt::format("border, {:.0f} % visible", 100 * part),
                [=, &real] { return border_cuts(real, part, 20, 3); });
  rows.scenes("border, 80 % visible, 20 px", [=, &real] { return border_cuts(in_diameters(real, {20}), 0.8, 20, 3); });
}

void light(Rows& rows) {
  rows.group("light");
  for (const double stops : {-2.5, -1.5, -0.75, 0.75, 1.0, 1.5})
    rows.pixels(fmt::format("{:+} stops", stops), [=](cv::Mat& m) { expose(m, stops); });
  for (const double gamma : {0.5, 0.7, 1.5, 2.2})
    rows.pixels(fmt::format("gamma {}", gamma), [=](cv::Mat& m) { apply_gamma(m, gamma); });
  for (const double corner : {0.5, 0.25, 0.1})
    rows.pixels(fmt::format("vignette to {}", corner), [=](cv::Mat& m) { vignette(m, corner); });
  rows.pixels("light 0.25..1.2 across",
              [](cv::Mat& m) { multiply_by(m, [](double x, double y) { return 0.25 + 0.95 * (0.6 * x + 0.4 * y); }); });
  rows.pixels("contrast 0.5", [](cv::Mat& m) { m.convertTo(m, -1, 0.5, 60); });
  rows.pixels("contrast 0.25", [](cv::Mat& m) { m.convertTo(m, -1, 0.25, 90); });
  rows.group("white balance");
  rows.pixels("warm", [](cv::Mat& m) { cast(m, 0.65, 0.95, 1.25); });
  rows.pixels("very warm", [](cv::Mat& m) { cast(m, 0.4, 0.85, 1.4); });
  rows.pixels("cool", [](cv::Mat& m) { cast(m, 1.3, 1.0, 0.75); });
  rows.pixels("very cool", [](cv::Mat& m) { cast(m, 1.5, 0.95, 0.5); });
  rows.pixels("greenish", [](cv::Mat& m) { cast(m, 0.8, 1.15, 0.85); });
  rows.pixels("pink", [](cv::Mat& m) { cast(m, 1.1, 0.8, 1.15); });
  rows.pixels(
      "grey", [](cv::Mat& m) { cv::cvtColor(m, m, cv::COLOR_BGR2GRAY), cv::cvtColor(m, m, cv::COLOR_GRAY2BGR); },
      false);
  rows.group("LEDs");
  for (const double levels : {60.0, 90.0, 120.0})
    rows.each(fmt::format("glare of {} on coin cells", levels),
              [=](const Scene& scene) { return with_glare(scene, levels); });
  for (const int half_degrees : {-5, -3, 3, 5})
    rows.pixels(fmt::format("hue {:+} deg", 2 * half_degrees), [=](cv::Mat& m) { turn_hue(m, half_degrees); });
  const std::pair<std::string, std::function<void(cv::Mat&)>> casts[] = {
      {"", [](cv::Mat&) {}},
      {", warm", [](cv::Mat& m) { cast(m, 0.65, 0.95, 1.25); }},
      {", cool", [](cv::Mat& m) { cast(m, 1.3, 1.0, 0.75); }},
      {", pink", [](cv::Mat& m) { cast(m, 1.1, 0.8, 1.15); }},
      {", greenish", [](cv::Mat& m) { cast(m, 0.8, 1.15, 0.85); }}};
  for (const auto& [name, change] : casts)
    rows.each("magenta beside blue" + name, [change = change](const Scene& scene) {
      return changed(recoloured(scene, hal::Led::magenta, 2), change);
    });
}

void sensors(Rows& rows) {
  rows.group("sensor");
  for (const double deviation : {5.0, 10.0, 20.0})
    rows.pixels(fmt::format("noise {}", deviation), [=](cv::Mat& m) { add_noise(m, deviation, 1); });
  for (const double part : {0.005, 0.02})
    rows.pixels(fmt::format("salt and pepper {} %", 100 * part), [=](cv::Mat& m) { add_salt(m, part, 1); });
  for (const int quality : {95, 50, 30, 15})
    rows.pixels(fmt::format("JPEG {}", quality), [=](cv::Mat& m) { compress(m, quality); });
  for (const double sigma : {1.0, 2.0, 3.0})
    rows.pixels(fmt::format("blur {} px", sigma), [=](cv::Mat& m) { cv::GaussianBlur(m, m, {}, sigma); });
  for (const double length : {5.0, 9.0, 13.0})
    rows.pixels(fmt::format("motion blur {} px", length), [=](cv::Mat& m) { motion_blur(m, length, 30); });
  for (const double diameter_px : {16.0, 24.0})
    rows.each(fmt::format("{} px, noise 6, blur 0.8, JPEG 50", diameter_px), [=](const Scene& scene) {
      return changed(with_diameter(scene, diameter_px),
                     [](cv::Mat& m) { cv::GaussianBlur(m, m, {}, 0.8), add_noise(m, 6, 1), compress(m, 50); });
    });
}

void arenas(Rows& rows, const Scenes& real) {
  const std::vector<std::string> names = {"light", "white", "dark",   "grey",  "black", "wood",  "parquet",
                                          "felt",  "blue",  "checks", "lines", "print", "carpet"};
  rows.group("arena");
  for (const std::string& arena : names) {
    rows.each(arena, [=](const Scene& scene) { return on_arena(scene, arena); });
    rows.each(arena + ", 20 px", [=](const Scene& scene) { return with_diameter(on_arena(scene, arena), 20); });
  }
  rows.group("collage");
  for (const std::string& arena : names)
    rows.scenes(arena + ", touching", [=, &real] {
      Scenes list;
      unsigned seed = 1;
      for (const double diameter_px : {16.0, 28.0, 44.0})
        list.push_back(collage(
            real, {.diameter_px = diameter_px, .arena = arena, .touching = true, .distractors = true, .seed = ++seed}));
      return list;
    });
}

void clutter(Rows& rows, const Scenes& real) {
  rows.group("clutter");
  for (const std::string& kind : clutter_kinds()) {
    rows.each("with " + kind,
              [=](const Scene& scene) { return with_clutter(scene, kind, 12, 2 * scene.robots[0].r_px, 5); });
    rows.scenes("with " + kind + ", 1 robot", [=, &real] {
      Scenes list;
      for (Scene& scene : cut_outs(real, 1, 12, 9)) {
        // as much arena again on every side
        cv::Mat wide;
        const int by = static_cast<int>(8 * scene.robots[0].r_px);
        cv::copyMakeBorder(scene.bgr, wide, by, by, by, by, cv::BORDER_REPLICATE);
        Scene one{scene.name, wide, scene.robots};
        for (TrueRobot& robot : one.robots)
          robot.x_px += by, robot.y_px += by, robot.led_x_px += by, robot.led_y_px += by;
        list.push_back(with_clutter(one, kind, 6, 2 * one.robots[0].r_px, static_cast<unsigned>(list.size())));
      }
      return list;
    });
  }
  rows.group("no robot");
  for (const double factor : {1.0, 0.5, 0.3, 2.0})
    rows.scenes(fmt::format("emptied, x {}", factor), [=, &real] { return emptied_all(real, factor); });
  rows.scenes("emptied, noise 10", [&real] {
    Scenes list;
    for (const Scene& scene : emptied_all(real, 1))
      list.push_back(changed(scene, [](cv::Mat& m) { add_noise(m, 10, 4); }));
    return list;
  });
  rows.scenes("emptied, JPEG 30", [&real] {
    Scenes list;
    for (const Scene& scene : emptied_all(real, 1)) list.push_back(changed(scene, [](cv::Mat& m) { compress(m, 30); }));
    return list;
  });
  for (const std::string arena : {"wood", "parquet", "felt", "checks", "lines", "print", "carpet"})
    rows.scenes("empty " + arena, [=] {
      Scenes list;
      for (const double robot_px : {16.0, 24.0, 48.0})
        list.push_back(collage({}, {.robots = 0, .diameter_px = robot_px, .arena = arena}));
      return list;
    });
  for (const std::string& kind : clutter_kinds())
    rows.scenes("only " + kind, [=, &real] {
      Scenes list;
      for (const double robot_px : {44.0, 24.0, 70.0})
        for (const std::size_t i : {0U, 1U}) list.push_back(with_clutter(emptied(real[i]), kind, 12, robot_px, 11));
      return list;
    });
}

}  // namespace

std::vector<PictureSeries> picture_series(const std::vector<Scene>& real) {
  Rows rows(real);
  sizes(rows);
  views(rows, real);
  light(rows);
  sensors(rows);
  arenas(rows, real);
  clutter(rows, real);
  return rows.rows;
}

}  // namespace arkmesh::tests
