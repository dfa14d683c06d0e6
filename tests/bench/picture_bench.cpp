// How well robots are found on pictures that were changed in many ways: a row each. A new detector for each picture, no
// size given. `told`: of lit LEDs that are not called unknown, those with the right colour. `brier`, `of LED`: Brier
// scores of the confidences of detections, and of colours.
//   detect_in_pictures [part of "group: name"] [--dump FOLDER, pictures with what is wrong drawn on them]
#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tests/support/pictures/picture_series.hpp"
#include "tracker/detect/detector.hpp"

namespace {

using namespace arkmesh;

// Missed robots red, what is no robot magenta, wrong colours yellow.
void dump(const std::string& file, const tests::Scene& scene, const std::vector<tracker::Detection>& found,
          const tests::Score& score) {
  const double scale = std::max(1.0, 900.0 / scene.bgr.cols);
  cv::Mat picture;
  cv::resize(scene.bgr, picture, {}, scale, scale, cv::INTER_NEAREST);
  const auto circle = [&](double x, double y, double r, const cv::Scalar& colour) {
    cv::circle(picture, cv::Point2d((x + 0.5) * scale, (y + 0.5) * scale), static_cast<int>(r * scale), colour, 2,
               cv::LINE_AA);
  };
  std::vector<char> seen(scene.robots.size(), 0);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const int robot = score.robot_of[i];
    if (robot < 0) {
      circle(found[i].x_px, found[i].y_px, found[i].r_px, {255, 0, 255});
      cv::putText(picture, fmt::format("{:.2f}", found[i].confidence),
                  cv::Point2d(found[i].x_px * scale, found[i].y_px * scale), cv::FONT_HERSHEY_SIMPLEX, 0.5,
                  {255, 0, 255});
      continue;
    }
    seen[static_cast<std::size_t>(robot)] = 1;
    const tests::TrueRobot& truth = scene.robots[static_cast<std::size_t>(robot)];
    if (found[i].led == truth.led)
      circle(found[i].x_px, found[i].y_px, found[i].r_px, {0, 200, 0});
    else {
      circle(found[i].x_px, found[i].y_px, found[i].r_px, {0, 255, 255});
      cv::putText(picture, fmt::format("{}>{}", static_cast<int>(truth.led), static_cast<int>(found[i].led)),
                  cv::Point2d(found[i].x_px * scale, found[i].y_px * scale), cv::FONT_HERSHEY_SIMPLEX, 0.5,
                  {0, 255, 255});
    }
  }
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (!seen[i]) circle(scene.robots[i].x_px, scene.robots[i].y_px, scene.robots[i].r_px, {0, 0, 255});
  cv::imwrite(file, picture);
}

}  // namespace

int main(int count, char** words) {
  std::string wanted, folder;
  for (int i = 1; i < count; ++i) {
    if (std::string(words[i]) == "--dump" && i + 1 < count)
      folder = words[++i];
    else
      wanted = words[i];
  }
  const std::vector<tests::Scene> real = tests::real_scenes();
  fmt::print("{:44} {:>6} {:>6} {:>6} {:>6} {:>7} {:>6} {:>6} {:>8} {:>6} {:>7} {:>6} {:>6}\n", "change", "robots",
             "false", "prec", "recall", "centre", "colour", "lit", "heading", "told", "unknown", "brier", "of LED");
  for (const tests::PictureSeries& row : tests::picture_series(real)) {
    const std::string name = row.group + ": " + row.name;
    if (name.find(wanted) == std::string::npos) continue;
    std::vector<tests::Score> all;
    int number = 0;
    for (const tests::Scene& scene : row.make()) {
      std::vector<tracker::Detection> found = tracker::Detector().search(scene.bgr);
      all.push_back(tests::score(found, scene));
      if (!folder.empty()) {
        std::filesystem::create_directories(folder);
        tests::Score whole = tests::score(found, scene.robots);
        dump(fmt::format("{}/{} {}.png", folder, name, number), scene, found, whole);
        cv::imwrite(fmt::format("{}/raw {} {}.png", folder, name, number++), scene.bgr);
      }
    }
    const tests::Score sum = tests::total(all);
    const auto part = [](int of, int all) { return all > 0 ? static_cast<double>(of) / all : 1.0; };
    fmt::print(
        "{:44} {:>6} {:>6} {:>6.3f} {:>6.3f} {:>7.2f} {:>6.3f} {:>6.3f} {:>8.2f} {:>6.3f} {:>7.3f} {:>6.3f} {:>6.3f}\n",
        name, sum.robots, sum.detections - sum.matched, sum.precision(), sum.recall(), sum.centre_error_px,
        sum.colours(), part(sum.leds_found, sum.leds_lit), sum.heading_error_deg,
        part(sum.leds_right, sum.leds_lit - sum.leds_unknown),
        sum.leds_lit > 0 ? part(sum.leds_unknown, sum.leds_lit) : 0, sum.brier(), sum.brier_of_colours());
    std::fflush(stdout);
  }
}
