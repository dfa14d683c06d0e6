// The detector on real pictures, as they are, larger, smaller and changed. Prints what it reaches.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>

#include "tests/support/pictures/collage.hpp"
#include "tests/support/pictures/picture_changes.hpp"
#include "tests/support/processes/thorough.hpp"
#include "tracker/detect/detector.hpp"

namespace arkmesh::tests {
namespace {

// One setting for all, no radius given: a new detector for each picture.
Score score_of(const Scene& scene) {
  return score(tracker::Detector().search(scene.bgr), scene);
}

Score score_of(const std::vector<Scene>& scenes, const std::function<Scene(const Scene&)>& change) {
  std::vector<Score> all;
  for (const Scene& scene : scenes) all.push_back(score_of(change(scene)));
  return total(all);
}

void print(const std::string& what, const Score& score) {
  fmt::print("{:28} {}\n", what, text(score));
}

TEST_CASE("real pictures") {
  // Proves: every robot of the six pictures is found and nothing else, at its place, with its colour and direction.
  std::vector<Score> all;
  for (const Scene& scene : real_scenes()) {
    const Score one = score_of(scene);
    print(scene.name, one);
    CHECK(one.precision() == 1.0);
    CHECK(one.recall() == 1.0);
    CHECK(one.centre_error_px < 1.0);
    all.push_back(one);
  }
  const Score sum = total(all);
  CHECK(sum.colours() >= 0.98);
  CHECK(sum.heading_error_deg < 6);
}

TEST_CASE("real pictures in other sizes") {
  // Proves: the size need not be told; from robots of 12 to 99 pixels the same settings find them.
  const std::vector<Scene> scenes = real_scenes();
  const Score twice = score_of(scenes, [](const Scene& scene) { return resized(scene, 2); });
  print("twice as large", twice);
  CHECK(twice.precision() == 1.0);
  CHECK(twice.recall() > 0.99);
  for (const double diameter_px : {40.0, 30.0, 24.0, 20.0, 16.0, 14.0, 12.0}) {
    if (!arkmesh::tests::thorough() && diameter_px != 20) continue;
    const Score small = score_of(scenes, [&](const Scene& scene) { return with_diameter(scene, diameter_px); });
    print(fmt::format("{} px across", diameter_px), small);
    CHECK(small.precision() >= (diameter_px == 20 ? 1.0 : 0.98));
    CHECK(small.recall() >= (diameter_px == 20 ? 1.0 : 0.97));
    CHECK(small.colours() >= 0.95);
  }
}

TEST_CASE("robots too small to be searched untold") {
  // Proves: what is smaller than 10 pixels counts only where somebody says so, as print has such letters.
  for (const Scene& scene : real_scenes()) {
    const Scene small = with_diameter(scene, 8.6);
    for (const tracker::Detection& one : tracker::Detector().search(small.bgr)) CHECK(one.r_px > 4.5);
    const auto told = tracker::Detector({.diameter_px = 8.6, .diameter_told = true}).search(small.bgr);
    CHECK(told.size() == small.robots.size());
  }
}

TEST_CASE("changed pictures") {
  // Proves: other light, noise, blur, compression, hue, polarity and points of view change little.
  const std::vector<Scene> scenes = real_scenes();
  std::size_t number = 0;
  for (const PictureChange& change : picture_changes()) {
    if (number++ % 5 != 0 && !arkmesh::tests::thorough()) continue;
    const Score changed = score_of(scenes, change.make);
    print(change.name, changed);
    CAPTURE(change.name);
    CHECK(changed.precision() >= 0.97);
    // No camera shows a negative; the nets saw none.
    CHECK(changed.recall() >= (change.name == "negative" ? 0.7 : 0.93));
    CHECK(changed.centre_error_px < 1.5);
  }
}

TEST_CASE("other arenas") {
  // Proves: robots are found on light, black, wooden, green, chequered and speckled arenas, touching, among cables,
  // coins and paper.
  const std::vector<Scene> scenes = real_scenes();
  for (const std::string arena : {"light", "black", "wood", "felt", "checks", "speckle"})
    for (const bool crowded : {false, true}) {
      if (!arkmesh::tests::thorough() && arena != "wood") continue;
      std::vector<Score> all;
      for (const double diameter_px : {16.0, 36.0})
        all.push_back(score_of(collage(
            scenes, {.diameter_px = diameter_px, .arena = arena, .touching = crowded, .distractors = crowded})));
      const Score sum = total(all);
      print(arena + (crowded ? ", crowded" : ""), sum);
      CAPTURE(arena);
      CHECK(sum.precision() >= 0.95);
      CHECK(sum.recall() >= (crowded ? 0.85 : 0.93));
    }
}

struct TruthRow {
  TrueRobot robot;
  bool led_sure = true;
};

// Frames of the clip's truth: frame,id,x_px,y_px,r_px,led,led_x_px,led_y_px.
std::map<int, std::vector<TruthRow>> clip_truth() {
  std::ifstream file(std::string(ARKMESH_TEST_DATA) + "/kilobot-images/bodyguard_clip_tracks.csv");
  std::map<int, std::vector<TruthRow>> frames;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    if (line.ends_with('\r')) line.pop_back();
    std::vector<std::string> cells;
    std::stringstream cut(line);
    for (std::string cell; std::getline(cut, cell, ',');) cells.push_back(cell);
    cells.resize(8);
    const auto number = [](const std::string& cell) { return cell.empty() ? std::nan("") : std::stod(cell); };
    const bool sure = cells[5] != "unsure";
    frames[std::stoi(cells[0])].push_back(
        {{number(cells[2]), number(cells[3]), number(cells[4]), sure ? led_named(cells[5]) : hal::Led::off,
          number(cells[6]), number(cells[7])},
         sure});
  }
  return frames;
}

TEST_CASE("real clip") {
  // Proves: in all frames of a clip of moving, touching robots all are found, by full searches and by following from
  // frame to frame.
  cv::VideoCapture clip(std::string(ARKMESH_TEST_DATA) + "/kilobot-images/bodyguard_clip.mp4");
  REQUIRE(clip.isOpened());
  const auto truth = clip_truth();
  tracker::Detector detector;
  std::vector<Score> searched, followed;
  std::vector<tracker::Expected> where;
  int colours = 0, sure = 0, frames = 0;
  for (cv::Mat bgr; clip.read(bgr); ++frames) {
    const std::vector<TruthRow>& rows = truth.at(frames);
    std::vector<TrueRobot> robots;
    for (const TruthRow& row : rows) robots.push_back(row.robot);
    const std::vector<tracker::Detection> all = detector.search(bgr);
    searched.push_back(score(all, robots));
    for (std::size_t i = 0; i < all.size(); ++i) {
      const int robot = searched.back().robot_of[i];
      if (robot < 0 || !rows[static_cast<std::size_t>(robot)].led_sure) continue;
      ++sure;
      if (all[i].led == robots[static_cast<std::size_t>(robot)].led) ++colours;
    }
    if (!where.empty()) {
      std::vector<tracker::Detection> seen;
      const auto again = detector.follow(bgr, where);
      for (std::size_t i = 0; i < again.size(); ++i)
        if (again[i])
          seen.push_back(*again[i]), where[i] = {again[i]->x_px, again[i]->y_px, again[i]->r_px, 0.6 * again[i]->r_px};
      followed.push_back(score(seen, robots));
    } else {
      for (const tracker::Detection& one : all) where.push_back({one.x_px, one.y_px, one.r_px, 0.6 * one.r_px});
    }
  }
  CHECK(frames == 242);
  const Score search = total(searched), follow = total(followed);
  print("clip, each frame searched", search);
  print("clip, followed", follow);
  fmt::print("clip: colour right in {:.2f} % of {} sure robot-frames\n", 100.0 * colours / sure, sure);
  CHECK(search.precision() >= 0.995);
  CHECK(search.recall() >= 0.995);
  CHECK(search.centre_error_px < 1.0);
  CHECK(follow.precision() >= 0.999);
  CHECK(follow.recall() >= 0.99);
  CHECK(colours >= 0.97 * sure);
}

}  // namespace
}  // namespace arkmesh::tests
