#include "sim_ode/host/firmware.hpp"

#include <utility>

namespace arkmesh::sim_ode {
namespace {

constexpr std::int64_t sleep_ticks = 244;  // 8 s

// Colours that the battery's state shows.
constexpr std::uint8_t green = 0x0C, blue = 0x30, yellow = 0x0F, red = 0x03;

}  // namespace

void Firmware::enter(State state, std::int64_t tick) {
  if (state == State::sleeping && state_ != State::sleeping) slept_at_ = tick;
  state_ = state;
}

Effects Firmware::hear(const Message& command, std::int64_t tick, RobotValues& values, BootLoader& loader) {
  if (state_ == State::loader) {
    reset_ = loader.hear(command);
    return {
        .outputs = reset_ ? Effects::Outputs::cut : Effects::Outputs::keep, .duties = {}, .colour = loader.colour()};
  }
  switch (command.type) {
    case type_run:
      if (state_ == State::running) return {};
      enter(State::running, tick);
      shown_ = State::running;
      return {.outputs = Effects::Outputs::connect, .duties = {}, .colour = {}};
    case type_read_uid: {
      // turns left for a bit that is 1, stands for one that is 0
      const bool dark = state_ != State::moving;
      const bool bit = command.data[0] < 16 && (values.uid >> command.data[0] & 1);
      Effects out = move(bit ? Motion::left : Motion::none, tick, values);
      if (dark) out.colour = 0;
      return out;
    }
    case type_calibrate:
      return calibrate(command, tick, values);
    case type_boot:
      loader.start();
      enter(State::loader, tick);
      break;
    case type_reset:
      reset_ = true;
      break;
    case type_sleep:
      enter(State::sleeping, tick);
      break;
    case type_wakeup:
      enter(State::idle, tick);
      break;
    case type_charge:
      enter(State::charging, tick);
      break;
    case type_voltage:
      enter(State::battery, tick);
      break;
    default:
      // unknown commands cut the motors; in state moving they are told again what to do
      if (state_ == State::moving) return move(motion_, tick, values);
      break;
  }
  return {.outputs = Effects::Outputs::cut, .duties = {}, .colour = {}};
}

// Modes: save, set the id, turn left, turn right, go straight.
Effects Firmware::calibrate(const Message& command, std::int64_t tick, RobotValues& values) {
  const std::uint8_t mode = command.data[0];
  const bool moves = state_ == State::moving;
  if (mode == 0) {
    if (!moves) return {};
    enter(State::idle, tick);
    return {.outputs = Effects::Outputs::cut, .duties = {}, .colour = {}, .save = true};
  }
  if (mode > 4) return moves ? move(motion_, tick, values) : Effects{};
  if (mode == 1) values.uid = static_cast<std::uint16_t>(command.data[1] | command.data[2] << 8);
  if (mode == 2) values.duties.turn_left = command.data[3];
  if (mode == 3) values.duties.turn_right = command.data[4];
  if (mode == 4) {
    values.duties.straight_left = command.data[5];
    values.duties.straight_right = command.data[6];
  }
  return move(static_cast<Motion>(mode - 1), tick, values);
}

Effects Firmware::move(Motion motion, std::int64_t tick, const RobotValues& values) {
  motion_ = motion;
  enter(State::moving, tick);
  Effects::Duties duties{0, 0};
  if (motion == Motion::left) duties.left = values.duties.turn_left;
  if (motion == Motion::right) duties.right = values.duties.turn_right;
  if (motion == Motion::straight) duties = {values.duties.straight_left, values.duties.straight_right};
  return {.outputs = Effects::Outputs::connect, .duties = duties, .colour = {}};
}

std::uint8_t Firmware::wake(std::int64_t tick) {
  if (heard_asleep_ == 0 || (tick - slept_at_) % sleep_ticks != 0) return 0;
  return std::exchange(heard_asleep_, std::uint8_t{0});
}

std::optional<std::uint8_t> Firmware::show(std::int16_t voltage) {
  if (!shows_another()) return std::nullopt;
  shown_ = state_;
  if (state_ == State::running || state_ == State::moving) return std::nullopt;
  if (state_ != State::battery) return std::uint8_t{0};
  return voltage > 682 ? green : voltage > 648 ? blue : voltage > 614 ? yellow : red;
}

}  // namespace arkmesh::sim_ode
