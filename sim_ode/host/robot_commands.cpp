// What the overhead controller's commands do to a robot, as RobotHost's robots obey them.
#include <algorithm>

#include "sim_ode/host/robot_host.hpp"

namespace arkmesh::sim_ode {

void RobotHost::take_command(const Message& message) {
  Cell& cell = cells_[index(robot_)];
  if (cell.state == State::loader) {
    cell.reset = loaders_[index(robot_)].hear(message);
    leds_.set(robot_, loaders_[index(robot_)].colour(), cursor_us_);
    if (!cell.reset) return;
  }
  if (message.type != type_run && message.type != type_read_uid && message.type != type_calibrate)
    motors_.connect(robot_, false, cursor_us_);
  switch (message.type) {
    case type_boot:
      if (cell.reset) break;
      loaders_[index(robot_)].start();
      change_state(State::loader);
      break;
    case type_reset:
      cell.reset = true;
      break;
    case type_sleep:
      change_state(State::sleeping);
      break;
    case type_wakeup:
      change_state(State::idle);
      break;
    case type_charge:
      change_state(State::charging);
      break;
    case type_voltage:
      change_state(State::battery);
      break;
    case type_run:
      if (cell.state != State::loader && cell.state != State::running) {
        motors_.connect(robot_, true, cursor_us_);
        change_state(State::running);
        cell.shown = State::running;
      }
      break;
    case type_read_uid:
      if (cell.state != State::moving) leds_.set(robot_, 0, cursor_us_);
      cell.motion = message.data[0] < 16 && (*abi_.uid >> message.data[0] & 1) ? 1 : 0;
      change_state(State::moving);
      break;
    case type_calibrate: {
      const std::uint8_t mode = message.data[0];
      if (mode == 0) {  // save
        if (cell.state != State::moving) break;
        uid_[index(robot_)] = *abi_.uid;
        motors_.calibration(robot_) = {*abi_.turn_left, *abi_.turn_right, *abi_.straight_left, *abi_.straight_right};
        motors_.connect(robot_, false, cursor_us_);
        change_state(State::idle);
        break;
      }
      if (mode > 4) break;
      if (mode == 1) *abi_.uid = static_cast<std::uint16_t>(message.data[1] | message.data[2] << 8);
      if (mode == 2) *abi_.turn_left = message.data[3];
      if (mode == 3) *abi_.turn_right = message.data[4];
      if (mode == 4) {
        *abi_.straight_left = message.data[5];
        *abi_.straight_right = message.data[6];
      }
      cell.motion = static_cast<std::uint8_t>(mode - 1);
      change_state(State::moving);
      break;
    }
    default:
      break;
  }
  if (cell.state == State::moving) {
    motors_.connect(robot_, true, cursor_us_);
    const std::uint8_t left = cell.motion == 1   ? *abi_.turn_left
                              : cell.motion == 3 ? *abi_.straight_left
                                                 : std::uint8_t{0};
    const std::uint8_t right = cell.motion == 2   ? *abi_.turn_right
                               : cell.motion == 3 ? *abi_.straight_right
                                                  : std::uint8_t{0};
    motors_.set(robot_, left, right, cursor_us_);
  }
  if (cell.reset) {
    // main() runs after all robots' turns
    forget_program(cell);
    resets_.push_back(robot_);
  }
}

void RobotHost::change_state(State state) {
  Cell& cell = cells_[index(robot_)];
  if (state == State::sleeping && cell.state != State::sleeping) cell.slept_at = tick_;
  cell.state = state;
}

// What a robot shows once its loop has returned. Flashes of a millisecond are nothing to a camera.
void RobotHost::show_state() {
  Cell& cell = cells_[index(robot_)];
  cell.shown = cell.state;
  if (cell.state == State::running || cell.state == State::moving) return;
  std::uint8_t colour = 0;
  if (cell.state == State::battery) {
    const std::int16_t v = voltage_[index(robot_)];
    colour = v > 682 ? 0x0C : v > 648 ? 0x30 : v > 614 ? 0x0F : 0x03;
  }
  leds_.set(robot_, colour, std::min(cursor_us_, tick_us - 1));
}

}  // namespace arkmesh::sim_ode
