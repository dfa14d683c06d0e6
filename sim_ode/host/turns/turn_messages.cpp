// What a robot hears and says in its turn: messages to its callbacks or its firmware, and the message of its send
// timer.
#include <cstring>

#include "sim_ode/host/turns/turns.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr std::uint32_t timer_count_us = 128;

}  // namespace

// Program code that runs in an interrupt.
template <class Call>
void Turns::call_back(Call call) {
  in_callback_ = true;
  callback_busy_ = 0;
  call();
  in_callback_ = false;
}

// Delivers the oldest message that the robot has not had yet. False when there is none.
bool Turns::deliver_next() {
  while (next_overhead_ < inbox_->overhead.size() && !inbox_->overhead[next_overhead_].reaches(robot_))
    ++next_overhead_;
  const bool overhead = next_overhead_ < inbox_->overhead.size(), infrared = next_infrared_ < past_infrared_;
  Firmware& firmware = cells_[index(robot_)].firmware;
  if ((!overhead && !infrared) || firmware.resets()) return false;

  const Message* message;
  DistanceReadings readings = overhead_;
  const bool from_robot =
      infrared && (!overhead || inbox_->infrared[next_infrared_].at_us < inbox_->overhead[next_overhead_].at_us);
  if (from_robot) {
    const Reception& reception = inbox_->infrared[next_infrared_++];
    message = &reception.message;
    readings = {reception.low_gain, reception.high_gain};
  } else {
    message = &inbox_->overhead[next_overhead_++].message;
  }

  // one buffer for all messages, as on the robot
  std::memcpy(abi_.rx_message, message, sizeof *message);
  abi_.rx_distance[0] = readings.low_gain;
  abi_.rx_distance[1] = readings.high_gain;
  const bool is_command = message->type > 127 && !(from_robot && bodies_.by_argos());
  if (is_command || firmware.state() == Firmware::State::loader) {
    hear(*message);
  } else if (*abi_.rx) {
    if (!from_robot) *abi_.measured = 0;
    note('X', *message, readings.low_gain, readings.high_gain);
    call_back([this] { call(*abi_.rx, abi_.rx_message, abi_.rx_distance); });
    log_end();
    if (!from_robot && *abi_.measured) measures_overhead_ = true;
    firmware.callback_ran();
  }
  return true;
}

void Turns::hear(const Message& command) {
  Cell& cell = cells_[index(robot_)];
  RobotValues values = read_values();
  const Effects effects = cell.firmware.hear(command, values, loaders_[index(robot_)]);
  write_values(values);
  note('v', values.uid, values.duties);
  if (abi_.registers && effects.outputs != Effects::Outputs::keep) abi_.registers[18] = abi_.registers[19] = 0;
  bodies_.apply(robot_, effects, values, cursor_us_);
  if (effects.save) save(values);
  if (cell.firmware.resets() || cell.firmware.state() == Firmware::State::loader) forget_program(cell);
  // main() runs after all robots' turns
  if (cell.firmware.resets()) resets_.push_back(robot_);
}

Fault Turns::send(const Outcome& outcome, Reply& reply) {
  if (!cells_[index(outcome.robot)].firmware.talks()) return {};  // no longer, since it backed off
  outcome_ = outcome;
  reply_ = &reply;
  robot_ = outcome.robot;
  memory_.copy_in(robot_);
  const Fault fault = run([](void* self) { static_cast<Turns*>(self)->ask_for_message(); });
  memory_.copy_out(robot_);
  return fault;
}

// As in the robot's timer interrupt: the message, then what the library does about the channel.
void Turns::ask_for_message() {
  using enum Outcome::Channel;
  call_back([this] {
    if (outcome_.channel != gone) {
      note('T');
      const auto* const message = *abi_.tx ? static_cast<const std::byte*>(call(*abi_.tx)) : nullptr;
      FaultGuard::enter_program();  // which may not be there
      log_end({message, message ? sizeof(Message) : 0});
      if (!message) return FaultGuard::leave_program();
      std::memcpy(&reply_->message.emplace(), message, sizeof(Message));
      FaultGuard::leave_program();
      if (outcome_.channel == busy) {
        note('B');
        const std::byte counts{abi_.back_off()};
        log_end({&counts, 1});
        reply_->back_off_us = std::to_integer<std::uint32_t>(counts) * timer_count_us;
      }
      if (outcome_.channel != free) return;
    }
    note('U');
    if (*abi_.tx_success) call(*abi_.tx_success);
    log_end();
    Firmware& firmware = cells_[index(robot_)].firmware;
    firmware.has_sent(timers_[index(robot_)].move(clocks_[index(robot_)].at_us, firmware.since_sent_us()));
    acted_[index(robot_)] = 1;
  });
}

}  // namespace arkmesh::sim_ode
