// Rows of the table that detect_in_pictures prints, with what is really reached; the weak ones, too.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>

#include "tests/support/pictures/other_arenas.hpp"
#include "tests/support/pictures/photo_effects.hpp"
#include "tests/support/pictures/picture_series.hpp"
#include "tests/support/processes/thorough.hpp"
#include "tracker/detect/detector.hpp"

namespace arkmesh::tests {
namespace {

struct Row {
  const char* name;    // group: name
  int max_false;       // detections of what is no robot
  double min_recall;   // of the robots
  double min_colours;  // of the LEDs
};

TEST_CASE("hard pictures") {
  // Proves: what docs/tracking.md says of pictures of few robots, among things that are none, in false colours and on
  // other arenas.
  const std::vector<Scene> real = real_scenes();
  const std::vector<PictureSeries> series = picture_series(real);
  std::size_t number = 0;
  for (const Row& row : {Row{"cut out: 1 robot", 0, 0.96, 0.96},
                         Row{"cut out: 1 robot, 12 px", 0, 0.93, 0.9},
                         Row{"cut out: 2 robots, 20 px", 0, 0.98, 0.95},
                         Row{"cut out: border, 80 % visible, 20 px", 0, 0.98, 0.97},
                         Row{"clutter: with black discs, 1 robot", 0, 0.9, 0.9},
                         Row{"clutter: with coins, 1 robot", 1, 0.9, 0.9},
                         Row{"clutter: with hands, 1 robot", 1, 0.9, 0.9},
                         Row{"clutter: with caps, 1 robot", 2, 0.9, 0.9},
                         Row{"no robot: emptied, x 1", 0, 1, 1},
                         Row{"no robot: emptied, x 0.3", 2, 1, 1},
                         Row{"no robot: empty print", 1, 1, 1},
                         Row{"no robot: only LEDs", 2, 1, 1},
                         Row{"no robot: only cables", 0, 1, 1},
                         Row{"white balance: warm", 0, 0.99, 0.94},
                         Row{"white balance: very cool", 0, 0.99, 0.91},
                         Row{"arena: grey, 20 px", 0, 0.95, 0.9},
                         Row{"arena: white, 20 px", 0, 0.97, 0.9},
                         Row{"no robot: only pads", 0, 1, 1},
                         Row{"clutter: with pads, 1 robot", 0, 0.96, 0.9},
                         Row{"clutter: with words", 0, 0.99, 0.95},
                         Row{"arena: print", 1, 0.87, 0.9},
                         Row{"no robot: only black discs", 1, 1, 1},
                         Row{"no robot: only caps", 1, 1, 1},
                         Row{"clutter: with caps", 2, 0.98, 0.9},
                         Row{"collage: felt, touching", 0, 0.9, 0.9},
                         Row{"clutter: with words, 1 robot", 1, 0.9, 0.9}}) {
    if (number++ % 5 != 0 && !arkmesh::tests::thorough()) continue;
    CAPTURE(row.name);
    const auto found = std::find_if(series.begin(), series.end(),
                                    [&](const PictureSeries& one) { return one.group + ": " + one.name == row.name; });
    REQUIRE(found != series.end());
    std::vector<Score> all;
    for (const Scene& scene : found->make()) all.push_back(score(tracker::Detector().search(scene.bgr), scene));
    const Score sum = total(all);
    fmt::print("{:40} {}\n", row.name, text(sum));
    CHECK(sum.detections - sum.matched <= row.max_false);
    CHECK(sum.recall() >= row.min_recall);
    CHECK(sum.colours() >= row.min_colours);
  }
}

TEST_CASE("robots through haze") {
  // Proves: where light lies over all of a picture, its robots are found, and followed from there; where no robot is,
  // none is found either.
  const std::vector<Scene> real = real_scenes();
  const auto six = std::ranges::find(real, std::size_t{6}, [](const Scene& scene) { return scene.robots.size(); });
  REQUIRE(six != real.end());
  const Scene hazy = changed(*six, [](cv::Mat& bgr) { bgr.convertTo(bgr, -1, 0.3, 100), add_noise(bgr, 3, 1); });
  tracker::Detector detector;
  const Score found = score(detector.search(hazy.bgr), hazy);
  CHECK(found.matched == 6);
  CHECK(found.detections == 6);
  std::vector<tracker::Expected> where;
  for (const TrueRobot& robot : hazy.robots) where.push_back({robot.x_px + 2, robot.y_px, robot.r_px, 10});
  CHECK(std::ranges::none_of(detector.follow(hazy.bgr, where), [](const auto& one) { return !one; }));
  for (const Scene& one : cut_outs({hazy}, 1, 3, 1))
    CHECK(score(tracker::Detector().search(one.bgr), one).matched == 1);
  const Scene empty = emptied(hazy);
  CHECK(tracker::Detector().search(empty.bgr).empty());
  // and again where the haze is gone
  CHECK(score(detector.search(six->bgr), *six).matched == 6);
}

}  // namespace
}  // namespace arkmesh::tests
