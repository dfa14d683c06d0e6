// See robot_pictures.hpp.
#include "tests/support/pictures/robot_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>

namespace arkmesh::tests {

hal::Led led_named(const std::string& name) {
  using hal::Led;
  static const std::pair<const char*, Led> names[] = {
      {"off", Led::off},     {"red", Led::red},         {"green", Led::green}, {"blue", Led::blue},
      {"white", Led::white}, {"magenta", Led::magenta}, {"cyan", Led::cyan},   {"yellow", Led::yellow}};
  for (const auto& [known, led] : names)
    if (name == known) return led;
  throw std::runtime_error("no LED colour is called " + name);
}

std::vector<Scene> real_scenes() {
  std::vector<Scene> scenes;
  for (const char* name :
       {"table_6robots", "bodyguard_f003", "bodyguard_f010", "bodyguard_f060", "bodyguard_f120", "bodyguard_f170"}) {
    const std::string base = std::string(ARKMESH_TEST_DATA) + "/kilobot-images/" + name;
    Scene scene{name, cv::imread(base + ".png", cv::IMREAD_COLOR), {}};
    std::ifstream file(base + ".json");
    if (scene.bgr.empty() || !file) throw std::runtime_error(base + ".png or .json is missing");
    for (const nlohmann::json& robot : nlohmann::json::parse(file)) {
      const auto place = [&](const char* key) {
        return robot[key].is_null() ? std::numeric_limits<double>::quiet_NaN() : robot[key].get<double>();
      };
      scene.robots.push_back(
          {place("x_px"), place("y_px"), place("r_px"), led_named(robot["led"]), place("led_x_px"), place("led_y_px")});
    }
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

Scene resized(const Scene& scene, double factor) {
  Scene out{fmt::format("{} x{:.2f}", scene.name, factor), {}, scene.robots, scene.also};
  cv::resize(scene.bgr, out.bgr, {}, factor, factor, factor > 1 ? cv::INTER_CUBIC : cv::INTER_AREA);
  const double by_x = static_cast<double>(out.bgr.cols) / scene.bgr.cols,
               by_y = static_cast<double>(out.bgr.rows) / scene.bgr.rows;
  const auto resize = [&](TrueRobot& robot) {
    robot.x_px = (robot.x_px + 0.5) * by_x - 0.5, robot.led_x_px = (robot.led_x_px + 0.5) * by_x - 0.5;
    robot.y_px = (robot.y_px + 0.5) * by_y - 0.5, robot.led_y_px = (robot.led_y_px + 0.5) * by_y - 0.5;
    robot.r_px *= factor;
  };
  for (TrueRobot& robot : out.robots) resize(robot);
  for (TrueRobot& robot : out.also) resize(robot);
  return out;
}

Scene with_diameter(const Scene& scene, double diameter_px) {
  double sum = 0;
  for (const TrueRobot& robot : scene.robots) sum += 2 * robot.r_px;
  return resized(scene, diameter_px * static_cast<double>(scene.robots.size()) / sum);
}

Score score(const std::vector<tracker::Detection>& found, const std::vector<TrueRobot>& robots) {
  Score result;
  result.robots = static_cast<int>(robots.size());
  result.detections = static_cast<int>(found.size());
  result.robot_of.assign(found.size(), -1);
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t j = 0; j < robots.size(); ++j)
      if (const double far = std::hypot(found[i].x_px - robots[j].x_px, found[i].y_px - robots[j].y_px);
          far < robots[j].r_px / 2)
        pairs.emplace_back(far, i, j);
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> taken(robots.size(), 0);
  for (const auto& [far, i, j] : pairs) {
    if (result.robot_of[i] >= 0 || taken[j]) continue;
    const tracker::Detection& seen = found[i];
    const TrueRobot& robot = robots[j];
    result.robot_of[i] = static_cast<int>(j);
    taken[j] = 1;
    ++result.matched;
    result.centre_error_px += far;
    result.radius_error_px += std::abs(seen.r_px - robot.r_px);
    const bool right = seen.led == robot.led, unknown = seen.led == hal::Led::unknown;
    result.colours_right += right;
    if (!unknown) ++result.colours_told, result.off_colours += std::pow(seen.led_confidence - right, 2);
    if (robot.led == hal::Led::off) continue;
    ++result.leds_lit;
    result.leds_unknown += unknown, result.leds_right += right;
    if (seen.led == hal::Led::off || unknown) continue;
    ++result.leds_found;
    const double truth = std::atan2(robot.led_y_px - robot.y_px, robot.led_x_px - robot.x_px);
    const double measured = std::atan2(seen.led_y_px - seen.y_px, seen.led_x_px - seen.x_px);
    result.heading_errors_deg.push_back(std::abs(std::remainder(measured - truth, 6.283185307179586)) *
                                        57.29577951308232);
  }
  for (std::size_t i = 0; i < found.size(); ++i)
    result.off_confidences += std::pow(found[i].confidence - (result.robot_of[i] >= 0), 2);
  if (result.matched) result.centre_error_px /= result.matched, result.radius_error_px /= result.matched;
  std::sort(result.heading_errors_deg.begin(), result.heading_errors_deg.end());
  if (!result.heading_errors_deg.empty())
    result.heading_error_deg = result.heading_errors_deg[result.heading_errors_deg.size() / 2];
  return result;
}

Score score(std::vector<tracker::Detection> found, const Scene& scene) {
  const Score asked = score(found, scene.robots);
  std::vector<tracker::Detection> rest;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (asked.robot_of[i] < 0) rest.push_back(found[i]);
  const Score besides = score(rest, scene.also);
  std::erase_if(found, [&](const tracker::Detection& one) {
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (besides.robot_of[i] >= 0 && rest[i].x_px == one.x_px && rest[i].y_px == one.y_px) return true;
    return false;
  });
  return score(found, scene.robots);
}

Score total(const std::vector<Score>& scores) {
  Score sum;
  for (const Score& one : scores) {
    sum.robots += one.robots, sum.detections += one.detections, sum.matched += one.matched;
    sum.colours_right += one.colours_right, sum.leds_lit += one.leds_lit, sum.leds_found += one.leds_found;
    sum.leds_unknown += one.leds_unknown, sum.leds_right += one.leds_right, sum.colours_told += one.colours_told;
    sum.off_confidences += one.off_confidences, sum.off_colours += one.off_colours;
    sum.centre_error_px += one.centre_error_px * one.matched, sum.radius_error_px += one.radius_error_px * one.matched;
    sum.heading_errors_deg.insert(sum.heading_errors_deg.end(), one.heading_errors_deg.begin(),
                                  one.heading_errors_deg.end());
  }
  if (sum.matched) sum.centre_error_px /= sum.matched, sum.radius_error_px /= sum.matched;
  std::sort(sum.heading_errors_deg.begin(), sum.heading_errors_deg.end());
  if (!sum.heading_errors_deg.empty())
    sum.heading_error_deg = sum.heading_errors_deg[sum.heading_errors_deg.size() / 2];
  return sum;
}

std::string text(const Score& score) {
  return fmt::format(
      "precision {:.3f} recall {:.3f} centre {:.2f} px radius {:.2f} px colour {:.1f} % LEDs found {}/{} heading "
      "{:.1f} deg",
      score.precision(), score.recall(), score.centre_error_px, score.radius_error_px, 100 * score.colours(),
      score.leds_found, score.leds_lit, score.heading_error_deg);
}

}  // namespace arkmesh::tests
