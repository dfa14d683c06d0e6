#include "sim_ode/host/robot_groups.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace arkmesh::sim_ode {

RobotGroups::RobotGroups(std::vector<Group> groups, Motors& motors, LedLights& leds, const RobotSensors& sensors,
                         const std::string& lab, std::uint64_t seed, const std::vector<std::uint16_t>& ids,
                         RobotOutput output) {
  const std::vector<std::string> names = std::move(output.names);
  int first = 0;
  for (Group& group : groups) {
    output.names.assign(names.begin() + first, names.begin() + first + group.robots);
    parts_.push_back({first,
                      group.robots,
                      std::make_unique<RobotHost>(std::move(group.program), group.robots, motors, leds, sensors, lab,
                                                  seed, ids, output, first),
                      {}});
    parts_.back().host->call_loop(group.loops_per_tick);
    first += group.robots;
  }
}

const RobotGroups::Part& RobotGroups::of(int robot) const {
  return *std::prev(std::ranges::upper_bound(parts_.begin() + 1, parts_.end(), robot, {}, &Part::first));
}

void RobotGroups::select(const Inbox& all, Part& part) {
  part.inbox.overhead = all.overhead;
  for (Inbox::Overhead& heard : part.inbox.overhead)
    if (!heard.missed.empty())
      heard.missed = {heard.missed.begin() + part.first, heard.missed.begin() + part.first + part.robots};
  part.inbox.infrared.clear();
  for (const Reception& reception : all.infrared) {
    if (reception.robot < part.first || reception.robot >= part.first + part.robots) continue;
    part.inbox.infrared.push_back(reception);
    part.inbox.infrared.back().robot -= part.first;
  }
}

void RobotGroups::tick(std::int64_t number, const Inbox& inbox) {
  if (parts_.size() == 1) return parts_[0].host->tick(number, inbox);
  offers_.clear();
  for (Part& part : parts_) {
    select(inbox, part);
    part.host->tick(number, part.inbox);
    for (const Offer& offer : part.host->offers()) offers_.push_back({offer.robot + part.first, offer.at_us});
  }
}

Reply RobotGroups::send_turn(Outcome outcome) {
  const Part& part = of(outcome.robot);
  outcome.robot -= part.first;
  return part.host->send_turn(outcome);
}

}  // namespace arkmesh::sim_ode
