// What the kit's sensors cost a scenario in C++: five of each of 1000 robots that walk about at random, at ten frames a
// second, as `scripts/measure kit` has them in Python. Prints microseconds a robot and frame, and simulated seconds in
// one of processor time, sensors alone.
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <numbers>
#include <vector>

#include "hal/random.hpp"
#include "scenarios/kit/neighbours.hpp"
#include "scenarios/kit/pheromone.hpp"
#include "scenarios/kit/sectors.hpp"

namespace {

using namespace arkmesh;
using namespace arkmesh::scenarios;

constexpr double side_m = 5, frame_s = 0.1;
constexpr int robots = 1000, frames = 600, frames_in_period = 20;

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

int main() {
  hal::RandomStream random(1, "kit_bench");
  std::vector<hal::Pose> poses;
  for (int i = 0; i < robots; ++i)
    poses.push_back({random.uniform(-side_m / 2, side_m / 2), random.uniform(-side_m / 2, side_m / 2),
                     random.uniform(-std::numbers::pi, std::numbers::pi)});
  kit::Pheromone trail(
      {.width_m = side_m, .height_m = side_m, .cell_m = 0.02, .half_life_s = 30, .diffusion_m2_s = 1e-5});
  const kit::Surroundings walls(side_m, side_m);
  kit::Surroundings walls_and_robots = walls;
  const kit::Sectors eight({.count = 8, .reach_m = 0.1}), four({.count = 4, .reach_m = 0.1});
  double sensed = 0;
  const double began_s = cpu_s();
  for (int frame = 0; frame < frames; ++frame) {
    std::vector<kit::Seen> seen;
    for (hal::Pose& pose : poses) {
      pose.x_m += 0.001 * std::cos(pose.heading_rad);
      pose.y_m += 0.001 * std::sin(pose.heading_rad);
      seen.push_back({{pose.x_m, pose.y_m}, hal::Led::off});
    }
    if (frame % frames_in_period == 0) {
      trail.pass(frames_in_period * frame_s);
      std::vector<kit::Surroundings::Disc> discs;
      for (const kit::Seen& robot : seen) discs.push_back({robot.place, 0.0165});
      walls_and_robots = walls;
      walls_and_robots.add_discs(discs);
    }
    for (int i = 0; i < robots; ++i) {
      const hal::Pose& pose = poses[static_cast<std::size_t>(i)];
      const hal::Point place{pose.x_m, pose.y_m};
      if (i % 10 == 0) trail.lay(place, 0.1);
      sensed += trail.at(place) + trail.gradient(place).x_m + trail.zones(pose, 4, std::numbers::pi, 0.05, 0.2);
      for (const double d : eight.distances_m(pose, walls)) sensed += d < 1;
      for (const double d : four.distances_m(pose, walls_and_robots)) sensed += d < 1;
    }
    for (const int n : kit::neighbours(seen, seen, 0.1)) sensed += n;
    for (const int n : kit::neighbours(seen, seen, 0.2, kit::only(hal::Led::red))) sensed += n;
  }
  const double took_s = cpu_s() - began_s;
  fmt::print("us {:.3f} speed {:.1f} sensed {:.6g}\n", 1e6 * took_s / (robots * frames), frames * frame_s / took_s,
             sensed);
}
