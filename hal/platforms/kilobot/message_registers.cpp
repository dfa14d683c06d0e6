// Packs words into composites, as the layout of the arena's robots says; a whole message goes alone.
#include "hal/platforms/kilobot/message_registers.hpp"

#include "hal/arenas/silent_link.hpp"

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
    const auto [place, is_new] = robot.by_slot.insert_or_assign(
        message.slot, Register{message.kind, message.value, message.whole, set_point_in(info_, message)});
    if (is_new)
      ++airtime_.waiting;
    else
      ++airtime_.replaced;
  }
}

void MessageRegisters::command(const hal::FleetCommand& command) {
  if (const char* reason = command_refusal(info_, command)) return counters_.add(reason);
  put(command);
}

void MessageRegisters::put(const hal::FleetCommand& command) {
  const char* const cost = commands_.put(command);
  if (!cost) return;
  counters_.add(cost);
  if (!is_word(command) && !makes_stand(command)) not_heard_.broadcasts.insert(command.type);
}

MessageRegisters::Register MessageRegisters::take(hal::RobotId receiver, Waiting& waiting) {
  const auto slot = waiting.next();
  const Register out = slot->second;
  waiting.next_slot = static_cast<std::uint8_t>(slot->first + 1);
  waiting.by_slot.erase(slot);
  next_receiver_ = receiver + 1;  // behind `everyone`: 0
  ++airtime_.sent;
  --airtime_.waiting;
  return out;
}

std::optional<MessageRegisters::Outgoing> MessageRegisters::next() {
  if (!commands_.empty()) return Outgoing{.message = fleet_message(commands_.take()), .is_command = true};
  if (waiting_.empty()) return std::nullopt;

  auto at = waiting_.lower_bound(next_receiver_);
  if (at == waiting_.end()) at = waiting_.begin();
  Outgoing out;
  if (at->second.next()->second.whole) {
    const hal::WholeMessage whole = *take(at->first, at->second).whole;
    out.message = {.data = whole.data, .type = whole.type};
    if (at->first != hal::everyone) out.only_to = at->first;
  } else {
    out.message.type = layout_.type;
    out.has_words = true;
    std::optional<hal::RobotId> passed_over;
    std::size_t group = 0;
    const Word nothing{.robot = nobody(layout_)};
    // three different robots at most: programs differ in which group they take when two bear their id
    for (std::size_t seen = 0; seen < waiting_.size() && group < groups; ++seen) {
      if (at->second.next()->second.whole) {
        if (!passed_over) passed_over = at->first;
      } else {
        const Register word = take(at->first, at->second);
        if (word.wheels)
          out.set_points.emplace_back(at->first, *word.wheels), put_word(out.message, group++, layout_, nothing);
        else
          put_word(out.message, group++, layout_, {.robot = at->first, .kind = word.kind, .value = word.value});
      }
      if (++at == waiting_.end()) at = waiting_.begin();
    }
    for (; group < groups; ++group) put_word(out.message, group, layout_, nothing);
    if (passed_over) next_receiver_ = *passed_over;
  }
  std::erase_if(waiting_, [](const auto& entry) { return entry.second.by_slot.empty(); });
  out.message = with_crc(out.message);
  return out;
}

std::uint64_t MessageRegisters::drop(hal::RobotId robot) {
  const auto at = waiting_.find(robot);
  if (at == waiting_.end()) return 0;
  const std::uint64_t messages = at->second.by_slot.size();
  waiting_.erase(at);
  not_heard_.words.insert(robot);
  return give_up(messages);
}

std::uint64_t MessageRegisters::drop_all() {
  for (const auto& [robot, waiting] : waiting_) not_heard_.words.insert(robot);
  waiting_.clear();
  return give_up(airtime_.waiting);
}

void MessageRegisters::decline(hal::RobotId robot) {
  ++airtime_.offered;
  ++airtime_.not_sent;
  not_heard_.words.insert(robot);
}

std::uint64_t MessageRegisters::give_up(std::uint64_t messages) {
  airtime_.waiting -= messages;
  airtime_.not_sent += messages;
  return messages;
}

}  // namespace arkmesh::hal::kilobot
