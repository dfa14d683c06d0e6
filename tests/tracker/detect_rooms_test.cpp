// The detector in rendered rooms, beyond what real pictures show: lamps that blow out coin cells and are mirrored by
// all robots, phones, tints, haze. Prints what it reaches.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/support/processes/thorough.hpp"
#include "tests/support/rooms/rooms.hpp"
#include "tracker/detect/detector.hpp"

namespace arkmesh::tests {
namespace {

// A centre is right within a quarter of the radius, a radius within 15 %.
struct Strict {
  int robots = 0, found = 0, wrong = 0, unlit = 0, called_white = 0, called_warm = 0, lit = 0, right = 0;
  double recall() const { return static_cast<double>(found) / robots; }
  void add(const std::vector<tracker::Detection>& detections, const Scene& scene) {
    const auto on = [](const tracker::Detection& one, const TrueRobot& robot) {
      return std::hypot(one.x_px - robot.x_px, one.y_px - robot.y_px) < 0.25 * robot.r_px &&
             std::abs(one.r_px / robot.r_px - 1) < 0.15;
    };
    robots += static_cast<int>(scene.robots.size());
    for (const TrueRobot& robot : scene.robots) {
      const auto one = std::ranges::find_if(detections, [&](const auto& some) { return on(some, robot); });
      if (one == detections.end()) continue;
      ++found;
      if (robot.led != hal::Led::off) {
        ++lit, right += one->led == robot.led;
        continue;
      }
      ++unlit;
      called_white += one->led == hal::Led::white;
      called_warm += one->led == hal::Led::red || one->led == hal::Led::yellow;
    }
    for (const tracker::Detection& one : detections) {
      const auto is = [&](const TrueRobot& robot) { return on(one, robot); };
      const auto cut = [&](const TrueRobot& robot) {
        return std::hypot(one.x_px - robot.x_px, one.y_px - robot.y_px) < 0.5 * robot.r_px;
      };
      wrong += std::ranges::none_of(scene.robots, is) && std::ranges::none_of(scene.also, cut);
    }
  }
};

TEST_CASE("robots in rendered rooms") {
  // Proves: bodies are found, not their shining cells; mirrored lamps are no LEDs; LEDs are named, by webcams, too; a
  // size told 5 % wrong loses hardly a robot.
  struct Rooms {
    RoomKind kind;
    const char* name;
    std::vector<std::uint64_t> seeds;
  };
  for (const Rooms& rooms : {Rooms{RoomKind::plain, "plain", {2, 8, 15, 26}},
                             {RoomKind::strange, "strange", {0, 1, 9, 11}},
                             {RoomKind::phone, "phone", {12}},
                             {RoomKind::webcam, "webcam", {0, 21}}}) {
    Strict untold, told;
    std::vector<std::uint64_t> all = rooms.seeds;
    if (thorough()) {
      all.clear();
      for (std::uint64_t seed = 0; seed < 30; ++seed) all.push_back(seed);
    }
    for (const std::uint64_t seed : all) {
      const Scene scene = room(rooms.kind, seed);
      untold.add(tracker::Detector().search(scene.bgr), scene);
      if (scene.robots.empty()) continue;
      double r_px = 0;
      for (const TrueRobot& robot : scene.robots) r_px += robot.r_px / static_cast<double>(scene.robots.size());
      told.add(tracker::Detector({.diameter_px = 2 * r_px * (seed % 2 ? 0.95 : 1.05), .diameter_told = true})
                   .search(scene.bgr),
               scene);
    }
    fmt::print(
        "{:8} recall {:.3f} of {}, false {}, unlit called white {}, red or yellow {} of {}, lit named right {} of {}; "
        "told recall {:.3f}, false {}\n",
        rooms.name, untold.recall(), untold.robots, untold.wrong, untold.called_white, untold.called_warm, untold.unlit,
        untold.right, untold.lit, told.recall(), told.wrong);
    CAPTURE(rooms.name);
    // 0.98 in plain rooms, 0.99 in strange ones. In plain room 26 unlit robots are black discs, and 4 of 31 are missed.
    // Compilers differ by a robot or two.
    CHECK(untold.recall() >= (thorough() ? 0.95 : 0.77));
    CHECK(untold.wrong <= (thorough() ? untold.robots / 33 : 0));
    CHECK(untold.called_white <= 2 + untold.unlit / 20);
    if (rooms.kind != RoomKind::phone) CHECK(untold.called_warm <= untold.unlit / 50);
    // At least 0.89 in 30 rooms of webcams, else 0.95; in two of them 47 of 50 with GCC, 43 with Clang.
    CHECK(untold.right + 0.5 >= 0.8 * untold.lit);
    CHECK(told.found + 1 >= untold.found - untold.robots / 100);
  }
}

}  // namespace
}  // namespace arkmesh::tests
