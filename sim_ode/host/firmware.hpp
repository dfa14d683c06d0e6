// The state machine of a robot's firmware: what commands do, when its program has turns, when it sends and wakes. Pure:
// a command goes in, what is to be done to motors, LED and EEPROM comes out.
#pragma once

#include <cstdint>
#include <optional>

#include "sim_ode/host/boot_loader.hpp"
#include "sim_ode/host/motors.hpp"
#include "sim_ode/host/reception.hpp"

namespace arkmesh::sim_ode {

// Of a robot's values in the EEPROM, those that commands change.
struct RobotValues {
  std::uint16_t uid = 0;
  Calibration duties;
};

// What a command does outside the firmware, at once.
struct Effects {
  enum class Outputs : std::uint8_t { keep, cut, connect };
  struct Duties {
    std::uint8_t left, right;
    bool operator==(const Duties&) const = default;
  };
  Outputs outputs = Outputs::keep;     // to the motors
  std::optional<Duties> duties;        // of the motors
  std::optional<std::uint8_t> colour;  // kilolib colour of the LED
  bool save = false;                   // values go to the EEPROM
};

class Firmware {
 public:
  enum class State : std::uint8_t { idle, running, sleeping, battery, charging, moving, loader, off };

  Firmware() = default;  // as after power-up
  explicit Firmware(State state) : state_(state), shown_(state) {}

  State state() const { return state_; }

  // A command in tick `tick`. `values` are those in the robot's memory, and may change.
  Effects hear(const Message& command, std::int64_t tick, RobotValues& values, BootLoader& loader);
  // It has heard RESET, or leaves the boot loader: nothing happens any more until it is powered up.
  bool resets() const { return reset_; }

  // Its program has turns: setup first, then loop.
  bool runs() const { return state_ == State::running && !reset_; }
  bool has_setup() const { return has_setup_; }
  void setup_is_done() { has_setup_ = true; }

  // In deep sleep it hears nothing but for moments, every 8 s.
  bool sleeps() const { return state_ == State::sleeping; }
  // The last command that was said while it slept; 0: none. Whoever repeats commands calls this for each.
  void say_asleep(std::uint8_t command) { heard_asleep_ = command; }
  // The command that it hears when it wakes in this tick; 0: it sleeps on.
  std::uint8_t wake(std::int64_t tick);

  // Its timer has ticked so often.
  void count(unsigned beats) { send_clock_ = static_cast<std::uint16_t>(send_clock_ + counts_per_tick * beats); }
  // It may send: never before setup has returned.
  bool talks() const { return runs() && has_setup_; }
  // Its send timer is due. `period` in timer counts.
  bool due(std::uint16_t period) const { return send_clock_ > period && talks(); }
  void has_sent() { send_clock_ = 0; }

  // Its LED shows a state that it is no longer in.
  bool shows_another() const { return shown_ != state_; }
  // What its LED is to show once loop has returned; nothing when that is the program's matter or shown already. Flashes
  // of a millisecond are nothing to a camera. `voltage` is its battery's reading, 0..1023.
  std::optional<std::uint8_t> show(std::int16_t voltage);

 private:
  static constexpr unsigned counts_per_tick = 255;
  enum class Motion : std::uint8_t { none, left, right, straight };  // in state moving

  void enter(State state, std::int64_t tick);
  Effects calibrate(const Message& command, std::int64_t tick, RobotValues& values);
  Effects move(Motion motion, std::int64_t tick, const RobotValues& values);

  State state_ = State::idle, shown_ = State::idle;
  Motion motion_ = Motion::none;
  bool has_setup_ = false, reset_ = false;
  std::uint8_t heard_asleep_ = 0;
  std::uint16_t send_clock_ = 0;  // timer counts since the last message, as on the robot: wraps
  std::int64_t slept_at_ = 0;     // tick in which deep sleep began
};

}  // namespace arkmesh::sim_ode
