#include "lab/arena_port.hpp"

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

void ArenaPort::say(std::span<const hal::ToRobot> messages, hal::LabTime now, std::uint32_t frame) {
  if (messages.empty()) return;
  bus_.publish(hal::channel::to_robots, hal::to_message(messages, now, frame));
  arena_.robots().offer(messages);
}

hal::Counters ArenaPort::counters() const {
  hal::Counters all;
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
