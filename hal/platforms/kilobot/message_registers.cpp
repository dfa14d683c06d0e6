// Packs what waits into composites, as the layout of the arena's robots says.
#include "hal/platforms/kilobot/message_registers.hpp"

#include "hal/silent_link.hpp"

namespace arkmesh::hal::kilobot {

void MessageRegisters::offer(std::span<const hal::ToRobot> newest) {
  for (const hal::ToRobot& message : newest) {
    ++airtime_.offered;
    if (const char* reason = hal::refusal(info_, message)) {
      ++airtime_.refused;
      counters_.add(reason);
      continue;
    }
    Waiting& robot = waiting_[message.robot];
    const auto [place, is_new] = robot.by_slot.insert_or_assign(message.slot, Register{message.kind, message.value});
    if (is_new)
      ++airtime_.waiting;
    else
      ++airtime_.replaced;
  }
}

void MessageRegisters::command(const hal::FleetCommand& command) {
  if (const char* reason = command_refusal(info_, command)) return counters_.add(reason);
  if (const char* reason = commands_.put(command)) counters_.add(reason);
}

std::optional<Message> MessageRegisters::next() {
  if (!commands_.empty()) return fleet_message(commands_.take());
  if (waiting_.empty()) return std::nullopt;

  Message message{.type = layout_.type};
  // three different robots at most: programs differ in which block they take when two bear their id
  const std::size_t robots = std::min(groups, waiting_.size());
  auto at = waiting_.lower_bound(next_robot_);
  for (std::size_t group = 0; group < groups; ++group) {
    Word word{.robot = nobody(layout_)};
    if (group < robots) {
      if (at == waiting_.end()) at = waiting_.begin();
      Waiting& robot = at->second;
      auto slot = robot.by_slot.lower_bound(robot.next_slot);
      if (slot == robot.by_slot.end()) slot = robot.by_slot.begin();
      word = {.robot = at->first, .kind = slot->second.kind, .value = slot->second.value};
      robot.next_slot = static_cast<std::uint8_t>(slot->first + 1);
      robot.by_slot.erase(slot);
      next_robot_ = static_cast<hal::RobotId>(at->first + 1);
      ++at;
      ++airtime_.sent;
      --airtime_.waiting;
    }
    put_word(message, group, layout_, word);
  }
  std::erase_if(waiting_, [](const auto& entry) { return entry.second.by_slot.empty(); });
  return with_crc(message);
}

std::uint64_t MessageRegisters::drop(hal::RobotId robot) {
  const auto at = waiting_.find(robot);
  if (at == waiting_.end()) return 0;
  const std::uint64_t messages = at->second.by_slot.size();
  waiting_.erase(at);
  return give_up(messages);
}

std::uint64_t MessageRegisters::drop_all() {
  waiting_.clear();
  return give_up(airtime_.waiting);
}

void MessageRegisters::decline() {
  ++airtime_.offered;
  ++airtime_.not_sent;
}

std::uint64_t MessageRegisters::give_up(std::uint64_t messages) {
  airtime_.waiting -= messages;
  airtime_.not_sent += messages;
  return messages;
}

}  // namespace arkmesh::hal::kilobot
