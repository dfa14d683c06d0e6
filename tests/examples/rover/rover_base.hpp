// The way to the rovers: sends at once what it is offered, tells the fleet's state again and again, so that a damaged
// packet heals, and collects what rovers say.
#pragma once

#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "tests/examples/rover/devices.hpp"
#include "tests/examples/rover/protocol.hpp"

namespace arkmesh::examples::rover {

class RoverBase final : public hal::RobotLink {
 public:
  // All outlive the base.
  RoverBase(const hal::ArenaInfo& info, ByteStream& stream, hal::Counters& counters)
      : info_(info), stream_(stream), counters_(counters) {}

  void offer(std::span<const hal::ToRobot> newest) override;
  hal::Airtime airtime() const override { return airtime_; }
  void command(const hal::FleetCommand& command) override;
  hal::NotHeard not_heard() override { return {}; }
  std::vector<hal::FromRobot> heard() override { return std::exchange(heard_, {}); }

  // For the arena.
  // Fleet commands go out from now on; until then the last one waits.
  void release();
  // Takes in what rovers have said.
  void listen();
  // Tells the fleet again whether it drives or stands.
  void repeat();
  // Asks one rover to light its LED, and all others to be dark.
  void ask_to_show(hal::RobotId robot);
  // The rover that has answered the question asked last.
  std::optional<hal::RobotId> shows() const { return shows_; }
  // The fleet drives no more, and has to say so.
  void stop();
  // Every rover has said that it stands, since the fleet was last told to drive, and since stop().
  bool all_stand() const { return standing_.size() == info_.robots.size(); }
  // Those of a fleet that should stand that have not said so.
  std::vector<hal::NotStanding> not_standing() const {
    std::vector<hal::NotStanding> out;
    for (const hal::RobotId robot : info_.robots)
      if (!drives_ && !standing_.contains(robot)) out.push_back({robot, hal::NotStanding::Why::not_told});
    return out;
  }

 private:
  void send(const Packet& packet) { stream_.write(encode(packet)); }

  const hal::ArenaInfo& info_;
  ByteStream& stream_;
  hal::Counters& counters_;
  PacketReader reader_;
  hal::Airtime airtime_;
  std::vector<hal::FromRobot> heard_;
  std::optional<hal::RobotId> asked_, shows_;
  std::set<hal::RobotId> standing_;
  bool released_ = false, drives_ = false;
};

}  // namespace arkmesh::examples::rover
