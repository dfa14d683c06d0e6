#include "hal/platforms/kilobot/fleet_queue.hpp"

#include <algorithm>

#include "hal/arenas/silent_link.hpp"

namespace arkmesh::hal::kilobot {
namespace {

using Kind = hal::FleetCommand::Kind;

std::uint8_t type_of(Kind kind) {
  switch (kind) {
    case Kind::run:
      return type_run;
    case Kind::pause:
      return type_wakeup;
    case Kind::reset:
      return type_reset;
    case Kind::sleep:
      return type_sleep;
    case Kind::voltage:
      return type_voltage;
    case Kind::charge:
      return type_charge;
    case Kind::broadcast:
      break;
  }
  return 0;
}

}  // namespace

Message fleet_message(const hal::FleetCommand& command) {
  Message message;
  message.type = type_of(command.kind);
  if (command.kind == Kind::broadcast) {
    message.type = command.type;
    message.data = command.data;
  }
  return with_crc(message);
}

const char* command_refusal(const hal::ArenaInfo& info, const hal::FleetCommand& command) {
  if (command.kind == Kind::broadcast && command.type > 127) return "fleet_command.refused.type";
  return hal::refusal(info, command);
}

bool is_word(const hal::FleetCommand& command) {
  return command.kind != Kind::reset && command.kind != Kind::broadcast;
}

bool makes_stand(const hal::FleetCommand& command) {
  return command.kind != Kind::run && command.kind != Kind::broadcast;
}

const char* FleetQueue::put(const hal::FleetCommand& command) {
  if (command.kind == Kind::broadcast) {
    const auto is_broadcast = [](const Waiting& waits) { return waits.command.kind == Kind::broadcast; };
    if (static_cast<std::size_t>(std::ranges::count_if(waiting_, is_broadcast)) >= max_broadcasts)
      return "fleet_command.refused.too_many";
    waiting_.push_back({command, {}});
    return nullptr;
  }
  // a reset leaves robots paused, whatever they should have done
  std::size_t replaced = 0;
  std::erase_if(waiting_, [&](const Waiting& waits) {
    replaced += is_word(waits.command) && waits.command.kind != command.kind;
    return is_word(waits.command) || (command.kind == Kind::reset && waits.command.kind == Kind::reset);
  });
  if (makes_stand(command))
    put_first(command);
  else
    waiting_.push_back({command, {}});
  return replaced > 0 ? "fleet_command.replaced" : nullptr;
}

bool FleetQueue::has_word() const {
  return std::ranges::any_of(waiting_, is_word, &Waiting::command);
}

hal::FleetCommand FleetQueue::take() {
  const hal::FleetCommand command = waiting_.front().command;
  waiting_.pop_front();
  return command;
}

void FleetQueue::note_time(hal::TimePoint now) {
  for (Waiting& waits : waiting_)
    if (!waits.since) waits.since = now;
}

std::vector<std::uint8_t> FleetQueue::expire(hal::TimePoint since) {
  // from behind the last `run` on
  const auto run = std::ranges::find(waiting_.rbegin(), waiting_.rend(), Kind::run,
                                     [](const Waiting& waits) { return waits.command.kind; });
  const auto expired = std::stable_partition(run.base(), waiting_.end(), [&](const Waiting& waits) {
    return waits.command.kind != Kind::broadcast || !waits.since || *waits.since > since;
  });
  std::vector<std::uint8_t> out;
  for (auto at = expired; at != waiting_.end(); ++at) out.push_back(at->command.type);
  waiting_.erase(expired, waiting_.end());
  return out;
}

std::size_t FleetQueue::drop_all() {
  const std::size_t dropped = waiting_.size();
  waiting_.clear();
  return dropped;
}

}  // namespace arkmesh::hal::kilobot
