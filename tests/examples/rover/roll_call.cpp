#include "tests/examples/rover/roll_call.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace arkmesh::examples::rover {
namespace {

constexpr double reach_m = 0.04;  // farther than a rover gets between two pictures, nearer than another rover may be

double distance_m(const hal::Pose& a, const hal::Pose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace

void RollCall::look(std::span<const Spot> spots, std::optional<hal::RobotId> shows) {
  std::vector<Spot> others(spots.begin(), spots.end());
  std::vector<hal::Observation> seen;
  const auto name = [&](hal::RobotId robot, std::vector<Spot>::iterator spot) {
    seen.push_back({.robot = robot, .pose = spot->pose, .led = spot->lit ? hal::Led::white : hal::Led::off});
    others.erase(spot);
  };
  for (const hal::Observation& before : seen_) {
    const auto nearest =
        std::ranges::min_element(others, {}, [&](const Spot& spot) { return distance_m(spot.pose, before.pose); });
    if (nearest != others.end() && distance_m(nearest->pose, before.pose) <= reach_m) name(before.robot, nearest);
  }
  const bool wanted = shows && std::ranges::find(seen, *shows, &hal::Observation::robot) == seen.end();
  if (wanted && std::ranges::count(others, true, &Spot::lit) == 1)
    name(*shows, std::ranges::find(others, true, &Spot::lit));
  std::ranges::sort(seen, {}, &hal::Observation::robot);
  seen_ = std::move(seen);
}

std::vector<hal::RobotId> RollCall::unnamed() const {
  std::vector<hal::RobotId> out;
  for (const hal::RobotId robot : robots_)
    if (!std::ranges::binary_search(seen_, robot, {}, &hal::Observation::robot)) out.push_back(robot);
  return out;
}

}  // namespace arkmesh::examples::rover
