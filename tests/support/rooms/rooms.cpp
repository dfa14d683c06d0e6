// See rooms.hpp.
#include "tests/support/rooms/rooms.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "emulator/camera.hpp"
#include "hal/random.hpp"
#include "tests/support/pictures/photo_effects.hpp"

namespace arkmesh::tests {
namespace {

constexpr double radius_m = hal::kilobot::body_radius_m;
using Seen = sim_ode::SimulatedArena::Seen;

struct Ranges {
  double min_r_px, max_r_px;
  double max_cell, max_glare, max_domes, max_tint, max_haze;
  int min_jpeg;
};

Ranges ranges_of(RoomKind kind) {
  if (kind == RoomKind::plain) return {6, 32, 1.9, 0.6, 0.6, 0.12, 25, 60};
  if (kind == RoomKind::strange) return {7, 40, 3, 1, 1, 0.3, 50, 35};
  if (kind == RoomKind::webcam) return {7, 18, 2.5, 0.8, 0.8, 0.15, 30, 35};
  return {55, 115, 2.2, 0.9, 0.9, 0.15, 20, 70};
}

// Robots stand apart or touch.
std::vector<Seen> stand(hal::RandomStream& chance, double width_m, double height_m, int count, double touching,
                        double lit) {
  std::vector<Seen> robots;
  const double w = width_m / 2 - 1.2 * radius_m, h = height_m / 2 - 1.2 * radius_m;
  for (int tries = 0; static_cast<int>(robots.size()) < count && tries < 40 * count; ++tries) {
    Seen one;
    one.pose = {chance.uniform(-w, w), chance.uniform(-h, h), chance.uniform(-std::numbers::pi, std::numbers::pi)};
    if (!robots.empty() && chance.uniform() < touching) {
      const Seen& beside = robots[chance.below(robots.size())];
      const double at = chance.uniform(-std::numbers::pi, std::numbers::pi);
      one.pose.x_m = beside.pose.x_m + 2.03 * radius_m * std::cos(at);
      one.pose.y_m = beside.pose.y_m + 2.03 * radius_m * std::sin(at);
      if (std::abs(one.pose.x_m) > w || std::abs(one.pose.y_m) > h) continue;
    }
    bool free = true;
    for (const Seen& other : robots)
      free = free && std::hypot(other.pose.x_m - one.pose.x_m, other.pose.y_m - one.pose.y_m) > 2.02 * radius_m;
    if (!free) continue;
    if (chance.uniform() < lit) {
      const auto bits = static_cast<unsigned>(1 + chance.below(7));
      one.red = bits & 1U ? 1 : 0, one.green = bits & 2U ? 1 : 0, one.blue = bits & 4U ? 1 : 0;
    }
    robots.push_back(one);
  }
  return robots;
}

}  // namespace

Scene room(RoomKind kind, std::uint64_t seed) {
  const Ranges ranges = ranges_of(kind);
  hal::RandomStream chance(seed, "rooms", static_cast<std::uint64_t>(kind));
  const auto size = chance.below(4);
  emulator::CameraSettings camera;
  camera.name = "room";
  camera.width_px = kind == RoomKind::phone ? 1200 : size == 0 ? 640 : size == 1 ? 854 : 1280;
  camera.height_px = kind == RoomKind::phone ? 1600 : size == 0 ? 480 : size == 1 ? 480 : 720;
  if (kind == RoomKind::webcam)
    camera.width_px = 800, camera.height_px = 600, camera.overlap = chance.uniform(0.1, 0.4);
  const double r_px = ranges.min_r_px * std::pow(ranges.max_r_px / ranges.min_r_px, chance.uniform());
  camera.pose.z_m = chance.uniform(0.7, 2);
  camera.pose.x_m = chance.uniform(-0.15, 0.15) * camera.pose.z_m;
  camera.pose.y_m = chance.uniform(-0.15, 0.15) * camera.pose.z_m;
  camera.pose.look_x_m = camera.pose.x_m, camera.pose.look_y_m = camera.pose.y_m;
  camera.pose.roll_rad = chance.uniform(-0.2, 0.2);
  camera.focal_px = r_px / radius_m * camera.pose.z_m;
  camera.vignetting = chance.uniform(0, 0.4);
  camera.blur_px = chance.uniform(0.5, 1.2) * (kind == RoomKind::phone ? 2 : 1);
  camera.noise = chance.uniform(0.5, 5);
  camera.brightness = chance.uniform(0.6, 1.15);
  camera.led_brightness = chance.uniform(0.4, 1.3);
  emulator::Scene scene;
  scene.seed = seed;
  const double px_m = radius_m / r_px, fill = chance.uniform(0.6, 1.05);
  scene.width_m = fill * camera.width_px * px_m, scene.height_m = fill * camera.height_px * px_m;
  scene.arena_grey = chance.uniform(110, 235);
  scene.texture = chance.uniform(0, 0.12);
  scene.wall_m = chance.uniform(0, 0.03);
  scene.wall_grey = chance.uniform(20, 240);
  scene.light_slope = chance.uniform(0, 0.5);
  scene.light_from_rad = chance.uniform(-std::numbers::pi, std::numbers::pi);
  scene.shadow = chance.uniform(0.1, 0.6);
  scene.distractors = chance.uniform() < 0.5;
  scene.cell_brightness = ranges.max_cell * std::pow(0.1, chance.uniform());
  scene.cell_radius = chance.uniform(0.62, 0.75);
  scene.glare = chance.uniform() < 0.6 ? chance.uniform(0, ranges.max_glare) : 0;
  scene.domes = chance.uniform() < 0.5 ? chance.uniform(0, ranges.max_domes) : 0;
  const double area = scene.width_m * scene.height_m / (4 * radius_m * radius_m);
  const int count = static_cast<int>(std::min(area * 0.3, 3 + 37 * chance.uniform()));
  const double touching = chance.uniform() < 0.4 ? chance.uniform(0, 0.7) : 0,
               lit = chance.uniform() < 0.25 ? 0.0 : chance.uniform(0.1, 1.0);
  const std::vector<Seen> robots = stand(chance, scene.width_m, scene.height_m, count, touching, lit);
  const emulator::Camera eye(camera, scene);
  Scene out{fmt::format("room {} of kind {}", seed, static_cast<int>(kind)), {}, {}};
  eye.picture(robots, {}, seed, out.bgr);
  for (const Seen& robot : robots) {
    const auto at = eye.model().project_near(robot.pose.x_m, robot.pose.y_m, scene.robot_height_m);
    if (!at) continue;
    const auto led_rad = robot.pose.heading_rad + robot.led_bearing_rad;
    const auto led = eye.model().project(robot.pose.x_m + hal::kilobot::led_radius_m * std::cos(led_rad),
                                         robot.pose.y_m + hal::kilobot::led_radius_m * std::sin(led_rad),
                                         scene.robot_height_m + hal::kilobot::led_above_board_m);
    TrueRobot truth{
        at->x_px,
        at->y_px,
        radius_m * std::sqrt(std::abs(at->xx * at->yy - at->xy * at->yx)),
        static_cast<hal::Led>((robot.red > 0 ? 1 : 0) + (robot.green > 0 ? 2 : 0) + (robot.blue > 0 ? 4 : 0)),
        std::numeric_limits<double>::quiet_NaN(),
        std::numeric_limits<double>::quiet_NaN()};
    if (truth.led != hal::Led::off && led) truth.led_x_px = led->x, truth.led_y_px = led->y;
    const double inside = std::min(std::min(truth.x_px, camera.width_px - 1 - truth.x_px),
                                   std::min(truth.y_px, camera.height_px - 1 - truth.y_px));
    if (inside >= truth.r_px)
      out.robots.push_back(truth);
    else if (inside > -truth.r_px)
      out.also.push_back(truth);
  }
  const double tint = ranges.max_tint;
  cast(out.bgr, 1 + chance.uniform(-tint, tint), 1 + chance.uniform(-tint / 2, tint / 2),
       1 + chance.uniform(-tint, tint));
  apply_gamma(out.bgr, chance.uniform(0.75, 1.35));
  const double haze = chance.uniform(0, ranges.max_haze);
  out.bgr.convertTo(out.bgr, -1, 1 - haze / 255, haze);
  if (chance.uniform() < 0.7) compress(out.bgr, ranges.min_jpeg + static_cast<int>(chance.below(96 - ranges.min_jpeg)));
  return out;
}

}  // namespace arkmesh::tests
