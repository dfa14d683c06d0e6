#include "sim_ode/host/turns/firmware.hpp"

#include <algorithm>
#include <utility>

namespace arkmesh::sim_ode {
namespace {

constexpr std::int64_t sleep_ticks = 244;    // 8 s
constexpr std::int64_t spin_up_us = 15'000;  // a motor starts with full power
constexpr std::uint8_t full_power = 255;

// Colours that the battery's state shows.
constexpr std::uint8_t green = 0x0C, blue = 0x30, yellow = 0x0F, red = 0x03;

}  // namespace

void Firmware::enter(State state) {
  if (state == State::sleeping && state_ != State::sleeping) slept_at_ = -1;
  spinning_ = Motion::none;
  state_ = state;
}

Effects Firmware::hear(const Message& command, RobotValues& values, BootLoader& loader) {
  if (state_ == State::loader) {
    reset_ = loader.hear(command);
    return {.outputs = reset_ ? Effects::Outputs::cut : Effects::Outputs::keep, .colour = loader.colour()};
  }
  switch (command.type) {
    case type_run: {
      if (state_ == State::running) return {};
      // the battery reads -1 while a message arrives, which the LED shows as flat
      const std::optional<std::uint8_t> colour =
          state_ == State::battery ? std::optional<std::uint8_t>(red) : std::nullopt;
      enter(State::running);
      starts_ = true;
      shown_ = State::running;
      return {.outputs = Effects::Outputs::connect, .colour = colour};
    }
    case type_read_uid: {
      // turns left for a bit that is 1, stands for one that is 0
      const bool moves = state_ == State::moving;
      if (!moves) moved_ = Motion::none;
      const bool bit = command.data[0] < 16 && (values.uid >> command.data[0] & 1);
      motion_ = bit ? Motion::left : Motion::none;
      return moves ? Effects{} : enter_moving(std::uint8_t{0});
    }
    case type_calibrate:
      return calibrate(command, values);
    case type_boot:
      loader.start();
      enter(State::loader);
      break;
    case type_reset:
      reset_ = true;
      break;
    case type_sleep:
      enter(State::sleeping);
      break;
    case type_wakeup:
      enter(State::idle);
      break;
    case type_charge:
      enter(State::charging);
      break;
    case type_voltage:
      enter(State::battery);
      break;
    default:
      // an unknown command cuts the motors, and the state stays
      break;
  }
  return {.outputs = Effects::Outputs::cut, .colour = {}};
}

// Modes: save, set the id, turn left, turn right, go straight. What it is told a second time with the same values is
// nothing new to it, also when it has been in other states meanwhile.
Effects Firmware::calibrate(const Message& command, RobotValues& values) {
  const bool moves = state_ == State::moving;
  const auto move = [this](Motion motion, const Calibration& before, const Calibration& after) {
    if (motion_ == motion && before == after) return;
    motion_ = motion;
    moved_ = Motion::none;
  };
  const Calibration before = values.duties;
  switch (command.data[0]) {
    case 0:
      if (!moves) return {};
      enter(State::idle);
      return {.outputs = Effects::Outputs::cut, .colour = {}, .save = true};
    case 1:
      values.uid = static_cast<std::uint16_t>(command.data[1] | command.data[2] << 8);
      motion_ = Motion::none;
      break;
    case 2:
      values.duties.turn_left = command.data[3];
      move(Motion::left, before, values.duties);
      break;
    case 3:
      values.duties.turn_right = command.data[4];
      move(Motion::right, before, values.duties);
      break;
    case 4:
      values.duties.straight_left = command.data[5];
      values.duties.straight_right = command.data[6];
      move(Motion::straight, before, values.duties);
      break;
    default:
      // any other mode is one, too, and says nothing of a motion
      break;
  }
  return moves ? Effects{} : enter_moving({});
}

Effects Firmware::enter_moving(std::optional<std::uint8_t> colour) {
  enter(State::moving);
  return {.outputs = Effects::Outputs::connect, .colour = colour};
}

Duties Firmware::duties_of(Motion motion, const RobotValues& values) {
  switch (motion) {
    case Motion::left:
      return {values.duties.turn_left, 0};
    case Motion::right:
      return {0, values.duties.turn_right};
    case Motion::straight:
      return {values.duties.straight_left, values.duties.straight_right};
    default:
      return {};
  }
}

void Firmware::steer(std::int64_t from_us, const RobotValues& values,
                     const std::function<void(Duties, std::int64_t us)>& set) {
  if (state_ != State::moving) return;
  if (spinning_ != Motion::none) {
    from_us = std::max<std::int64_t>(from_us, spin_us_);
    set(duties_of(std::exchange(spinning_, Motion::none), values), from_us);
  }
  if (motion_ == Motion::none) {
    moved_ = Motion::none;
    set({}, from_us);
    return;
  }
  if (motion_ == moved_) return;
  moved_ = motion_;
  set({.left = motion_ == Motion::right ? std::uint8_t{0} : full_power,
       .right = motion_ == Motion::left ? std::uint8_t{0} : full_power},
      from_us);
  const std::int64_t end_us = from_us + spin_up_us;
  if (end_us < tick_us) {
    set(duties_of(motion_, values), end_us);
  } else {
    spinning_ = motion_;
    spin_us_ = static_cast<std::uint16_t>(end_us - tick_us);
  }
}

std::uint8_t Firmware::wake(std::int64_t tick) {
  if (heard_asleep_ == 0 || (tick - slept_at_) % sleep_ticks != 0) return 0;
  return std::exchange(heard_asleep_, std::uint8_t{0});
}

std::optional<std::uint8_t> Firmware::shown_after(std::uint8_t type, std::int16_t voltage) const {
  if (state_ == State::loader || state_ == State::off || state_ == State::sleeping) return std::nullopt;
  const State next = type == type_wakeup    ? State::idle
                     : type == type_voltage ? State::battery
                     : type == type_charge  ? State::charging
                                            : state_;
  if (next == state_) return std::nullopt;
  Firmware after = *this;
  after.enter(next);
  return after.show(voltage);
}

std::optional<std::uint8_t> Firmware::show(std::int16_t voltage) {
  if (!shows_another()) return std::nullopt;
  shown_ = state_;
  if (state_ == State::running || state_ == State::moving) return std::nullopt;
  if (state_ != State::battery) return std::uint8_t{0};
  return voltage > 682 ? green : voltage > 648 ? blue : voltage > 614 ? yellow : red;
}

}  // namespace arkmesh::sim_ode
