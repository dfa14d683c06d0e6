#include "tests/examples/rover/rover_base.hpp"

#include <algorithm>

#include "hal/arenas/silent_link.hpp"

namespace arkmesh::examples::rover {

void RoverBase::offer(std::span<const hal::ToRobot> newest) {
  for (const hal::ToRobot& message : newest) {
    ++airtime_.offered;
    if (const char* reason = hal::refusal(info_, message)) {
      ++airtime_.refused;
      counters_.add(reason);
    } else {
      ++airtime_.sent;
      send({Packet::Type::tell, static_cast<std::uint16_t>(message.robot), message.kind,
            static_cast<std::int32_t>(message.value)});
    }
  }
}

void RoverBase::command(const hal::FleetCommand& command) {
  if (const char* reason = hal::refusal(info_, command)) return counters_.add(reason);
  drives_ = command.kind == hal::FleetCommand::Kind::run;
  if (released_) repeat();
}

void RoverBase::release() {
  if (std::exchange(released_, true)) return;
  repeat();
}

void RoverBase::repeat() {
  if (drives_) standing_.clear();
  send({drives_ ? Packet::Type::go : Packet::Type::stand});
}

void RoverBase::stop() {
  drives_ = false;
  standing_.clear();
}

void RoverBase::ask_to_show(hal::RobotId robot) {
  if (asked_ != robot) shows_.reset();
  asked_ = robot;
  send({Packet::Type::show, static_cast<std::uint16_t>(robot)});
}

void RoverBase::listen() {
  const auto bytes = stream_.read();
  for (const Packet& packet : reader_.read(bytes)) {
    if (!std::ranges::binary_search(info_.robots, packet.robot))
      counters_.add("from_robots.refused.unknown_robot");
    else if (packet.type == Packet::Type::answer)
      heard_.push_back({packet.robot, packet.kind, packet.value});
    else if (packet.type == Packet::Type::stands)
      standing_.insert(packet.robot);
    else if (packet.type == Packet::Type::shows && asked_ == packet.robot)
      shows_ = packet.robot;
  }
  counters_.set("from_robots.damaged_bytes", reader_.damaged_bytes());
}

}  // namespace arkmesh::examples::rover
