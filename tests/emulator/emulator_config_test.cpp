// One bad file per rule: each is refused with file, line and key.
#include "emulator/emulator_config.hpp"

#include <doctest/doctest.h>

#include <string>

#include "tests/emulator/emulator_builder.hpp"

using namespace arkmesh;
using namespace arkmesh::emulator;

namespace {

std::string error(const TestEmulator& emulator) {
  try {
    emulator.make();
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return {};
}

std::string emulator_with(const std::string& line) {
  return error({.robots = 2, .emulator = line});
}
std::string camera_with(const std::string& line) {
  return error({.robots = 2, .cameras = "[[emulator.camera]]\nwidth_px = 320\nheight_px = 240\nz_m = 0.8\n" + line});
}

}  // namespace

TEST_CASE("every key of an emulator has its range") {
  // The sentence names the key; a wrong camera says what is wrong with it.
  CHECK(emulator_with("frames_per_s = 0.0").find("frames_per_s") != std::string::npos);
  CHECK(emulator_with("ids = \"mixed\"").find("ids") != std::string::npos);
  CHECK(emulator_with("jpeg_quality = 101").find("jpeg_quality") != std::string::npos);
  CHECK(emulator_with("exposure_s = 2.0").find("exposure_s") != std::string::npos);
  CHECK(emulator_with("colour = 1").find("colour") != std::string::npos);
  CHECK(camera_with("name = \"a/b\"").find("part of a URL") != std::string::npos);
  CHECK(camera_with("[[emulator.camera]]\nname = \"camera0\"").find("another camera") != std::string::npos);
  CHECK(camera_with("distortion = [1.0]").find("five numbers") != std::string::npos);
  CHECK(camera_with("distortion = [-5.0, 0.0, 0.0, 0.0, 0.0]").find("folds") != std::string::npos);
  CHECK(camera_with("x_m = 30.0\nlook_x_m = 60.0").find("whole arena") != std::string::npos);
  CHECK(camera_with("focal_px = 5.0").find("longer focal_px") != std::string::npos);
  CHECK(error({.robots = 2, .events = "[[emulator.event]]\nat_s = 1.0"}).find("do") != std::string::npos);
  CHECK(error({.robots = 2, .events = "[[emulator.event]]\nat_s = -1.0\ndo = \"help\""}).find("at_s") !=
        std::string::npos);
  CHECK(error({.poses = "0, 0, 0", .robots = 2}).find("start_poses") != std::string::npos);
}

TEST_CASE("an emulator without cameras gets one that sees the whole arena") {
  // The four corners lie inside its picture.
  const Emulator emulator = TestEmulator{.robots = 2, .cameras = ""}.make();
  REQUIRE(emulator.cameras() == 1);
  for (const auto& [x, y] : {std::pair{-0.25, -0.2}, {0.25, -0.2}, {-0.25, 0.2}, {0.25, 0.2}}) {
    const auto at = emulator.camera(0).model().project(x, y, 0);
    REQUIRE(at);
    CHECK(at->x > 0);
    CHECK(at->y > 0);
    CHECK(at->x < 1919);
    CHECK(at->y < 1079);
  }
}

TEST_CASE("an arena that keeps time by itself does not fit into an emulator") {
  // arena.pace must be 0.
  const auto config = hal::Config::from_text(TestEmulator{.robots = 2}.text(), "emulator.toml", {"arena.pace=1"});
  CHECK_THROWS_WITH_AS(Emulator(config.root()), doctest::Contains("must be 0"), hal::ConfigError);
}
