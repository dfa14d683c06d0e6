#include "lab/arena_port.hpp"

#include <utility>

namespace arkmesh::lab {

ArenaPort::ArenaPort(hal::Arena& arena, hal::Bus& private_bus) : arena_(arena), bus_(private_bus) {}

ArenaPort::Snapshot ArenaPort::take_snapshot() {
  Snapshot snapshot{.heard = arena_.robots().heard(), .frame = arena_.poses().latest()};
  if (!snapshot.heard.empty())
    bus_.publish(hal::channel::from_robots, hal::to_message(snapshot.heard, arena_.clock().now()));
  if (snapshot.frame)
    for (const pose_frame_t& part : hal::to_messages(*snapshot.frame)) bus_.publish(hal::channel::poses, part);
  return snapshot;
}

void ArenaPort::publish_info() {
  bus_.publish(hal::channel::arena, hal::to_message(arena_.info()));
}

void ArenaPort::say(std::span<const hal::ToRobot> messages, std::span<const hal::FleetCommand> commands,
                    hal::LabTime now, std::uint32_t frame) {
  if (!messages.empty()) {
    bus_.publish(hal::channel::to_robots, hal::to_message(messages, now, frame));
    arena_.robots().offer(messages);
  }
  for (const hal::FleetCommand& command : commands) {
    const fleet_command_t message = hal::to_message(command, now);
    bus_.publish(hal::channel::fleet_command, message);
    obey(message);
  }
}

void ArenaPort::keep_still(bool still, hal::LabTime now) {
  if (std::exchange(still_, still) == still || !told_to_run_) return;
  const hal::FleetCommand command{.kind = still ? hal::FleetCommand::Kind::pause : hal::FleetCommand::Kind::run};
  bus_.publish(hal::channel::fleet_command, hal::to_message(command, now));
  arena_.robots().command(command);
}

void ArenaPort::pause_for_good(hal::LabTime now, std::uint32_t frame) {
  const hal::FleetCommand pause{.kind = hal::FleetCommand::Kind::pause};
  say({}, {&pause, 1}, now, frame);
}

void ArenaPort::obey(const fleet_command_t& command) {
  using Kind = hal::FleetCommand::Kind;
  const auto known = hal::from_message(command);
  if (!known) return counters_.add("fleet_command.refused.unknown");
  const bool run = known->kind == Kind::run;
  if (run || known->kind == Kind::pause || known->kind == Kind::reset || known->kind == Kind::sleep) told_to_run_ = run;
  if (!run || !still_) arena_.robots().command(*known);
}

hal::Counters ArenaPort::counters() const {
  hal::Counters all = counters_;
  all.merge(arena_.counters(), "arena.");
  const hal::Airtime air = arena_.robots().airtime();
  all.set("to_robots.offered", air.offered);
  all.set("to_robots.sent", air.sent);
  all.set("to_robots.replaced", air.replaced);
  all.set("to_robots.refused", air.refused);
  all.set("to_robots.not_sent", air.not_sent);
  return all;
}

}  // namespace arkmesh::lab
