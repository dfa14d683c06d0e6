// A field holds a number for each robot that says something: its id and the value.
#include "scenarios/kit/voices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

Voices::Voices(std::string name, int values) : field_name_("kit." + std::move(name)), values_(values) {
  if (values < 1 || values > most_values)
    throw std::invalid_argument(fmt::format("voices say one of {} values; give 1 to {}", values, most_values));
}

Voices::Voices(std::string name, int values, double range_m) : Voices(std::move(name), values) {
  range_m_ = range_m;
  if (!(range_m > 0) || !std::isfinite(range_m))
    throw std::invalid_argument(fmt::format("nobody hears voices within {:g} m; give a positive range", range_m));
}

Voices::Voices(std::string name, int values, const std::vector<std::pair<Robot, Robot>>& graph)
    : Voices(std::move(name), values) {
  for (const auto& [one, other] : graph) {
    if (one == other)
      throw std::invalid_argument(fmt::format("robot {} of {} is joined to itself in a graph", one.second, one.first));
    joined_[one].insert(other);
    joined_[other].insert(one);
  }
}

void Voices::begin(lab::Lab& lab) const {
  for (const auto& [robot, _] : joined_)
    if (std::ranges::find(lab.labs(), robot.first) == lab.labs().end())
      throw std::invalid_argument(fmt::format("a graph joins robot {} of {}, and the labs are {}", robot.second,
                                              robot.first, fmt::join(lab.labs(), ", ")));
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
      others_.push_back({{each, robot}, {at->in_shared.x_m, at->in_shared.y_m}, value});
    }
  }
}

std::vector<int> Voices::heard(const lab::Lab& lab, const hal::PoseFrame& frame) const {
  std::vector<int> counts(frame.robots.size() * static_cast<std::size_t>(values_), 0);
  if (range_m_ > 0)
    hear_within_range(lab, frame, counts);
  else
    hear_by_graph(lab, frame, counts);
  return counts;
}

void Voices::hear_by_graph(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<int>& counts) const {
  std::map<Robot, int> says;
  for (const auto& [robot, value] : own_) says[{lab.name(), robot}] = value;
  for (const Speaker& other : others_) says[other.who] = other.value;
  for (std::size_t row = 0; row < frame.robots.size(); ++row) {
    const auto joined = joined_.find({lab.name(), frame.robots[row].robot});
    if (joined == joined_.end()) continue;
    for (const Robot& other : joined->second)
      if (const auto said = says.find(other); said != says.end())
        ++counts[row * static_cast<std::size_t>(values_) + static_cast<std::size_t>(said->second)];
  }
}

void Voices::hear_within_range(const lab::Lab& lab, const hal::PoseFrame& frame, std::vector<int>& counts) const {
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
  each_near(std::span(robots).first(own), robots, range_m_, [&](std::size_t robot, std::size_t other) {
    if (robot != other && says[other] >= 0)
      ++counts[robot * static_cast<std::size_t>(values_) + static_cast<std::size_t>(says[other])];
  });
}

}  // namespace arkmesh::scenarios::kit
