// The trained nets by themselves: the search across tiles of a large picture, and the close look at circles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/support/pictures/photo_effects.hpp"
#include "tracker/detect/look_net.hpp"
#include "tracker/detect/search_net.hpp"

namespace arkmesh::tests {
namespace {

const Scene& six_robots() {
  static const std::vector<Scene> real = real_scenes();
  return *std::ranges::find_if(real, [](const Scene& scene) { return scene.robots.size() == 6; });
}

TEST_CASE("the search net loses no robot where tiles of a large picture meet") {
  // The same robot 5 px in radius everywhere, in steps of the net's cells, across the borders of tiles.
  const TrueRobot& robot = six_robots().robots[0];
  const int side = 40, half = static_cast<int>(4 * robot.r_px);
  const cv::Rect round(static_cast<int>(robot.x_px) - half, static_cast<int>(robot.y_px) - half, 2 * half, 2 * half);
  cv::Mat one, picture(600, 1140, CV_8UC3, cv::mean(six_robots().bgr));
  cv::resize(six_robots().bgr(round), one, {side, side}, 0, 0, cv::INTER_AREA);
  std::size_t pasted = 0;
  for (int y = 20, line = 0; y + side < picture.rows; y += 44, ++line)
    for (int x = 20 + 4 * (line % 4); x + side < picture.cols; x += 44, ++pasted)
      one.copyTo(picture(cv::Rect(x, y, side, side)));
  tracker::SearchNet net;
  net.look_at(picture);
  std::vector<tracker::NetFind> found;
  net.find(5, 0.3, found);
  REQUIRE(found.size() == pasted);
  const auto [least, most] = std::ranges::minmax_element(found, {}, &tracker::NetFind::score);
  CHECK(least->score > 0.9);
  CHECK(most->score - least->score < 0.02);
}

TEST_CASE("a close look tells robots from their coin cells and from the arena, turned or mirrored") {
  const Scene& scene = six_robots();
  std::vector<tracker::Circle> robots, others;
  for (const TrueRobot& robot : scene.robots) {
    robots.push_back({robot.x_px, robot.y_px, robot.r_px});
    others.push_back({robot.x_px, robot.y_px, 0.65 * robot.r_px});
    others.push_back({robot.x_px + 1.2 * robot.r_px, robot.y_px, robot.r_px});
  }
  others.push_back({-500, 20, 30});  // outside
  others.push_back({3, 3, 400});
  tracker::LookNet net;
  CHECK(std::ranges::count_if(net.probabilities(scene.bgr, robots), [](double sure) { return sure > 0.5; }) >= 5);
  for (const double sure : net.probabilities(scene.bgr, others)) CHECK(sure < 0.5);
  CHECK(net.probabilities(scene.bgr, {}).empty());
  // A turned picture shows the same: here one so small that it is not shrunk before.
  cv::Mat small, turned;
  cv::resize(scene.bgr, small, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::rotate(small, turned, cv::ROTATE_90_CLOCKWISE);
  std::vector<tracker::Circle> before, after;
  for (const tracker::Circle& one : robots) {
    before.push_back({one.x_px / 2 - 0.25, one.y_px / 2 - 0.25, one.r_px / 2});
    after.push_back({small.rows - 1 - before.back().y_px, before.back().x_px, before.back().r_px});
  }
  const std::vector<double> as_is = net.probabilities(small, before), as_turned = net.probabilities(turned, after);
  for (std::size_t i = 0; i < robots.size(); ++i) CHECK(std::abs(as_is[i] - as_turned[i]) < 0.05);
  // So does a mirrored one, since the net is shown both; its answers to one of them differ by up to 0.13.
  cv::Mat mirrored;
  cv::flip(small, mirrored, 0);
  std::vector<tracker::Circle> in_mirror = before;
  for (tracker::Circle& one : in_mirror) one.y_px = small.rows - 1 - one.y_px;
  const std::vector<double> as_mirrored = net.probabilities(mirrored, in_mirror);
  for (std::size_t i = 0; i < robots.size(); ++i) CHECK(std::abs(as_is[i] - as_mirrored[i]) < 0.03);
}

}  // namespace
}  // namespace arkmesh::tests
