// A field holds a number for each robot that says something: its id and the value.
#include "scenarios/kit/voices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "lab/exchange/world_message.hpp"
#include "scenarios/kit/neighbours.hpp"

namespace arkmesh::scenarios::kit {
namespace {

constexpr int value_bits = 8;

}  // namespace

Voices::Voices(std::string name, int values, double range_m)
    : field_name_("kit." + std::move(name)), values_(values), range_m_(range_m) {
  if (values < 1 || values > most_values)
    throw std::invalid_argument(fmt::format("voices say one of {} values; give 1 to {}", values, most_values));
  if (!(range_m > 0) || !std::isfinite(range_m))
    throw std::invalid_argument(
        fmt::format("voices within {:g} m are heard by nobody; give a positive range", range_m));
}

void Voices::begin(lab::Lab& lab) const {
  lab.declare({.name = field_name_,
               .length = lab::max_shared_robot + std::size_t{1},
               .low = 0,
               .high = (std::int64_t{lab::max_shared_robot} + 1) << value_bits,
               .up_to = true});
  lab.publish(field_name_, {});
}

void Voices::say(hal::RobotId robot, int value) {
  if (value < 0 || value >= values_)
    own_.erase(robot);
  else
    own_[robot] = value;
}

void Voices::tell(lab::Lab& lab) const {
  std::vector<std::int64_t> told;
  told.reserve(own_.size());
  for (const auto& [robot, value] : own_) told.push_back(std::int64_t{robot} << value_bits | value);
  lab.publish(field_name_, std::move(told));
}

void Voices::on_period(const lab::Lab& lab) {
  others_.clear();
  for (const std::string& each : lab.labs()) {
    if (each == lab.name()) continue;
    const auto& robots = lab.state(each).robots;
    for (const std::int64_t told : lab.field(each, field_name_)) {
      const auto robot = static_cast<hal::RobotId>(told >> value_bits);
      const int value = static_cast<int>(told & ((1 << value_bits) - 1));
      const auto at = std::ranges::lower_bound(robots, robot, {}, &lab::SharedRobot::robot);
      if (at == robots.end() || at->robot != robot || value >= values_) continue;
      others_.push_back({{at->in_shared.x_m, at->in_shared.y_m}, value});
    }
  }
}

std::vector<int> Voices::heard(const lab::Lab& lab, const hal::PoseFrame& frame) const {
  std::vector<Seen> robots;
  std::vector<int> says;
  for (const hal::Observation& robot : frame.robots) {
    const hal::Pose at = lab.projection().to_shared(robot.pose);
    robots.push_back({{at.x_m, at.y_m}});
    const auto said = own_.find(robot.robot);
    says.push_back(said == own_.end() ? -1 : said->second);
  }
  const std::size_t own = robots.size();
  for (const Speaker& other : others_) {
    robots.push_back({other.in_shared});
    says.push_back(other.value);
  }
  std::vector<int> counts(own * static_cast<std::size_t>(values_), 0);
  each_near(std::span(robots).first(own), robots, range_m_, [&](std::size_t robot, std::size_t other) {
    if (robot != other && says[other] >= 0)
      ++counts[robot * static_cast<std::size_t>(values_) + static_cast<std::size_t>(says[other])];
  });
  return counts;
}

}  // namespace arkmesh::scenarios::kit
