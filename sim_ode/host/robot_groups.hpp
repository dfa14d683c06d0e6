// All robots of an arena: groups that run programs of their own, a host each. Robots are numbered through, as in the
// arena.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim_ode/host/robot_host.hpp"

namespace arkmesh::sim_ode {

class RobotGroups {
 public:
  struct Group {
    std::shared_ptr<const RobotProgram> program;
    int robots;
    int loops_per_tick = 1;
  };
  // Not empty. As RobotHost's.
  RobotGroups(std::vector<Group> groups, Motors& motors, LedLights& leds, const RobotSensors& sensors,
              const std::string& lab, std::uint64_t seed, const std::vector<std::uint16_t>& ids, RobotOutput output);

  // Calls visit(host) for that of each group.
  template <class Visit>
  void visit(Visit&& visit) {
    for (Part& part : parts_) visit(*part.host);
  }
  // Each as RobotHost's.
  std::uint64_t failed_robots() const { return sum(&RobotHost::failed_robots); }
  std::uint64_t waited_robots() const { return sum(&RobotHost::waited_robots); }
  std::uint64_t heap_misuse() const { return sum(&RobotHost::heap_misuse); }
  void tick(std::int64_t number, const Inbox& inbox);
  std::span<const Offer> offers() const { return parts_.size() == 1 ? parts_[0].host->offers() : offers_; }
  Reply send_turn(Outcome outcome);
  void fetch_memory(int robot) const { of(robot).host->fetch_memory(robot - of(robot).first); }
  void set_power(int robot, bool on) { of(robot).host->set_power(robot - of(robot).first, on); }
  bool powered(int robot) const { return of(robot).host->powered(robot - of(robot).first); }
  std::optional<std::uint8_t> shown_after(int robot, std::uint8_t type) const {
    return of(robot).host->shown_after(robot - of(robot).first, type);
  }
  std::uint16_t id_of(int robot) const { return of(robot).host->id_of(robot - of(robot).first); }
  const BootLoader& loader(int robot) const { return of(robot).host->loader(robot - of(robot).first); }
  FaultGuard& guard() { return parts_[0].host->guard(); }

 private:
  struct Part {
    int first, robots;
    std::unique_ptr<RobotHost> host;
    Inbox inbox;  // of its own robots, counted from 0
  };
  const Part& of(int robot) const;
  template <class Count>
  std::uint64_t sum(Count count) const {
    std::uint64_t out = 0;
    for (const Part& part : parts_) out += (part.host.get()->*count)();
    return out;
  }
  static void select(const Inbox& all, Part& part);

  std::vector<Part> parts_;
  std::vector<Offer> offers_;  // of several parts, ascending
};

}  // namespace arkmesh::sim_ode
