// A RobotLink to robots that do not exist: accepts what a platform could carry, sends nothing, hears nothing.
#pragma once

#include "hal/arenas/arena.hpp"
#include "hal/counters.hpp"

namespace arkmesh::hal {

// Why an arena refuses a message, as its counter's name; null when it carries it.
const char* refusal(const ArenaInfo& info, const ToRobot& message);
const char* refusal(const ArenaInfo& info, const FleetCommand& command);

class SilentLink final : public RobotLink {
 public:
  // Both outlive the link.
  SilentLink(const ArenaInfo& info, Counters& counters) : info_(info), counters_(counters) {}
  void offer(std::span<const ToRobot> newest) override;
  Airtime airtime() const override { return airtime_; }
  void command(const FleetCommand& command) override;
  NotHeard not_heard() override { return {}; }
  std::vector<FromRobot> heard() override { return {}; }

 private:
  const ArenaInfo& info_;
  Counters& counters_;
  Airtime airtime_;
};

}  // namespace arkmesh::hal
