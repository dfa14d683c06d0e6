// The state machine of a robot's firmware: what commands do, when its program has turns, when it sends and wakes. Pure:
// a command goes in, what is to be done to motors, LED and EEPROM comes out.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "sim_ode/host/motors.hpp"
#include "sim_ode/host/turns/boot_loader.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

// Of a robot's values in the EEPROM, those that commands change.
struct RobotValues {
  std::uint16_t uid = 0;
  Calibration duties;
};

struct Duties {
  std::uint8_t left = 0, right = 0;
  bool operator==(const Duties&) const = default;
};

// What a command does outside the firmware, at once: it is heard in an interrupt.
struct Effects {
  enum class Outputs : std::uint8_t { keep, cut, connect };
  Outputs outputs = Outputs::keep;     // to the motors; both duties are 0 when they are cut or connected
  std::optional<std::uint8_t> colour;  // kilolib colour of the LED
  bool save = false;                   // values go to the EEPROM
};

class Firmware {
 public:
  enum class State : std::uint8_t { idle, running, sleeping, battery, charging, moving, loader, off };

  Firmware() = default;  // as after power-up
  explicit Firmware(State state) : state_(state), shown_(state) {}

  State state() const { return state_; }

  // A command. `values` are those in the robot's memory, and may change.
  Effects hear(const Message& command, RobotValues& values, BootLoader& loader);
  // It has heard RESET, or leaves the boot loader: nothing happens any more until it is powered up.
  bool resets() const { return reset_; }

  // Its program has turns: setup first, then loop.
  bool runs() const { return state_ == State::running && !reset_; }
  bool has_setup() const { return has_setup_; }
  // Loop follows, whatever commands have come while setup ran.
  void setup_is_done() {
    has_setup_ = true;
    starts_ = false;
    state_ = State::running;
  }
  // RUN takes effect where the main loop calls loop, not while an earlier call still waits.
  void calls_loop() { starts_ = false; }
  // Told to turn or to go straight, it does so from its main loop: not before the program's loop has returned. Says
  // which duties it sets in this tick, `from_us` after the tick's start at the earliest, in time order.
  void steer(std::int64_t from_us, const RobotValues& values, const std::function<void(Duties, std::int64_t us)>& set);

  // Its program loops, and nothing else happens in a tick without messages.
  bool only_loops() const { return talks() && !shows_another(); }

  // In deep sleep it hears nothing but for moments, every 8 s.
  bool sleeps() const { return state_ == State::sleeping; }
  // Loop has returned: now it does sleep.
  void fall_asleep(std::int64_t tick) {
    if (slept_at_ < 0) slept_at_ = tick;
  }
  // The last command that was said while it slept; 0: none. Whoever repeats commands calls this for each.
  void say_asleep(std::uint8_t command) { heard_asleep_ = command; }
  // The command that it hears when it wakes in this tick; 0: it sleeps on.
  std::uint8_t wake(std::int64_t tick);

  // Its timer has ticked so often.
  void count(unsigned beats) { send_clock_ = static_cast<std::uint16_t>(send_clock_ + counts_per_tick * beats); }
  // It may send: never before setup has returned.
  bool talks() const { return runs() && has_setup_ && !starts_; }
  // Its send timer is due. `period` in timer counts.
  bool due(std::uint16_t period) const { return send_clock_ > period && talks(); }
  // The next message is due so many ticks later than its period says: -1, 0 or 1.
  void has_sent(int later = 0) { send_clock_ = static_cast<std::uint16_t>(-static_cast<int>(counts_per_tick) * later); }
  std::int64_t since_sent_us() const { return send_clock_ * hal::kilobot::tick_us / counts_per_tick; }

  // The program may have changed its LED in kilo_message_rx. Where no program runs, the main loop shows the state
  // again: in state idle when it comes round, every 201 ms.
  void callback_ran() {
    if (state_ == State::running || state_ == State::moving) return;
    shown_ = State::off;
    round_ticks_ = 0;
  }
  bool comes_round() { return shown_ != State::off || ++round_ticks_ >= ticks_per_round; }
  // Its LED shows a state that it is no longer in.
  bool shows_another() const { return shown_ != state_; }
  // What its LED is to show once loop has returned; nothing when that is the program's matter or shown already. Flashes
  // of a millisecond are nothing to a camera. `voltage` is its battery's reading, 0..1023.
  std::optional<std::uint8_t> show(std::int16_t voltage);
  // The same once it has heard a command of that type, where that changes its state; else nothing.
  std::optional<std::uint8_t> shown_after(std::uint8_t type, std::int16_t voltage) const;

 private:
  static constexpr unsigned counts_per_tick = 255, ticks_per_round = 6;
  enum class Motion : std::uint8_t { none, left, right, straight };  // in state moving

  void enter(State state);
  Effects calibrate(const Message& command, RobotValues& values);
  Effects enter_moving(std::optional<std::uint8_t> colour);
  static Duties duties_of(Motion motion, const RobotValues& values);

  State state_ = State::idle, shown_ = State::idle;
  Motion motion_ = Motion::none;    // as told
  Motion moved_ = Motion::none;     // that the main loop has seen; kept in other states
  Motion spinning_ = Motion::none;  // whose motors get full power still
  bool has_setup_ = false, reset_ = false;
  bool starts_ = false;  // RUN has been heard, and loop not been called since
  std::uint8_t heard_asleep_ = 0;
  std::uint8_t round_ticks_ = 0;  // since the last callback
  std::uint16_t send_clock_ = 0;  // timer counts since the last message, as on the robot: wraps
  std::uint16_t spin_us_ = 0;     // of full power, left at the start of the next tick
  std::int64_t slept_at_ = -1;    // tick in which deep sleep began
};

}  // namespace arkmesh::sim_ode
