// One bad file per rule: each is refused with file, line and key.
#include "emulator/room_config.hpp"

#include <doctest/doctest.h>

#include <string>

#include "tests/emulator/room_builder.hpp"

using namespace arkmesh;
using namespace arkmesh::emulator;

namespace {

std::string complaint(const TestRoom& room) {
  try {
    room.make();
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return {};
}

std::string room_with(const std::string& line) {
  return complaint({.robots = 2, .room = line});
}
std::string camera_with(const std::string& line) {
  return complaint({.robots = 2, .cameras = "[[room.camera]]\nwidth_px = 320\nheight_px = 240\nz_m = 0.8\n" + line});
}

}  // namespace

TEST_CASE("every key of a room has its range") {
  // The sentence names the key; a wrong camera says what is wrong with it.
  CHECK(room_with("frames_per_s = 0.0").find("frames_per_s") != std::string::npos);
  CHECK(room_with("ids = \"mixed\"").find("ids") != std::string::npos);
  CHECK(room_with("jpeg_quality = 101").find("jpeg_quality") != std::string::npos);
  CHECK(room_with("exposure_s = 2.0").find("exposure_s") != std::string::npos);
  CHECK(room_with("colour = 1").find("colour") != std::string::npos);
  CHECK(camera_with("name = \"a/b\"").find("part of a URL") != std::string::npos);
  CHECK(camera_with("[[room.camera]]\nname = \"camera0\"").find("another camera") != std::string::npos);
  CHECK(camera_with("distortion = [1.0]").find("five numbers") != std::string::npos);
  CHECK(camera_with("distortion = [-5.0, 0.0, 0.0, 0.0, 0.0]").find("folds") != std::string::npos);
  CHECK(camera_with("x_m = 30.0\nlook_x_m = 60.0").find("whole arena") != std::string::npos);
  CHECK(camera_with("focal_px = 5.0").find("longer focal_px") != std::string::npos);
  CHECK(complaint({.robots = 2, .events = "[[room.event]]\nat_s = 1.0"}).find("do") != std::string::npos);
  CHECK(complaint({.robots = 2, .events = "[[room.event]]\nat_s = -1.0\ndo = \"help\""}).find("at_s") !=
        std::string::npos);
  CHECK(complaint({.poses = "0, 0, 0", .robots = 2}).find("start_poses") != std::string::npos);
}

TEST_CASE("a room without cameras gets one that sees the whole arena") {
  // The four corners lie inside its picture.
  const Room room = TestRoom{.robots = 2, .cameras = ""}.make();
  REQUIRE(room.cameras() == 1);
  for (const auto& [x, y] : {std::pair{-0.25, -0.2}, {0.25, -0.2}, {-0.25, 0.2}, {0.25, 0.2}}) {
    const auto at = room.camera(0).model().project(x, y, 0);
    REQUIRE(at);
    CHECK(at->x > 0);
    CHECK(at->y > 0);
    CHECK(at->x < 1919);
    CHECK(at->y < 1079);
  }
}

TEST_CASE("an arena that keeps time by itself does not fit into a room") {
  // arena.pace must be 0.
  const auto config = hal::Config::from_text(TestRoom{.robots = 2}.text(), "room.toml", {"arena.pace=1"});
  CHECK_THROWS_WITH_AS(Room(config.root()), doctest::Contains("must be 0"), hal::ConfigError);
}
