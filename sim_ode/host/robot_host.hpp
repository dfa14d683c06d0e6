// Runs one Kilobot program on many robots, tick by tick: gives each robot its own memory in turn, delivers what it
// heard, lets its clock tick, and calls its loop. Programs that wait in delay() keep a stack of their own meanwhile;
// others cost none. Knows nothing of positions or of who hears whom.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/host/boot_loader.hpp"
#include "sim_ode/host/fault_guard.hpp"
#include "sim_ode/host/led_lights.hpp"
#include "sim_ode/host/reception.hpp"
#include "sim_ode/host/robot_memory.hpp"
#include "sim_ode/host/robot_program.hpp"
#include "sim_ode/host/send_timer.hpp"
#include "sim_ode/host/worker_stacks.hpp"
#include "sim_ode/motors.hpp"

namespace arkmesh::sim_ode {

// A robot's program crashed, hangs, or gave up: one sentence naming robot, time and source line.
class ProgramFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What robots hear at the start of a tick.
struct Inbox {
  struct Overhead {
    std::uint32_t at_us = 0;  // as Reception::at_us
    Message message;
    std::vector<std::uint8_t> missed;  // by robot; empty: nobody missed it
  };
  std::vector<Overhead> overhead;   // ascending at_us; everybody's
  std::vector<Reception> infrared;  // ascending by robot, then at_us
};

class RobotHost {
 public:
  // Readings are 0..1023.
  struct Sensors {
    std::function<std::int16_t(int robot)> light;  // empty: dark
    // Whether a message arrives at lab time at_us; all sensors read -1 then. Empty: never.
    std::function<bool(int robot, std::int64_t at_us)> receiving;
  };

  // Powers all robots up: main() runs until kilo_start(). `motors` and `leds` outlive the host. Robots' ids are 0, 1,
  // 2, ... unless `ids` holds others. Throws ProgramFault.
  RobotHost(std::shared_ptr<const RobotProgram> program, int robots, Motors& motors, LedLights& leds, Sensors sensors,
            const std::string& lab, std::uint64_t seed, double clock_spread = 0,
            const std::vector<std::uint16_t>& ids = {});
  ~RobotHost();
  RobotHost(const RobotHost&) = delete;
  RobotHost& operator=(const RobotHost&) = delete;

  // All robots' turns for tick `number` (1, 2, ...). Throws ProgramFault, which ends the host's use.
  void tick(std::int64_t number, const Inbox& inbox);

  // Robots whose timer comes in the present tick with something to send, perhaps. Ascending.
  std::span<const Offer> offers() const { return offers_; }
  // The robot's turn when its moment has come. Calls kilo_message_tx and, when the channel is free, so that the message
  // goes out undisturbed, kilo_message_tx_success; the robot's send timer starts anew. Otherwise counts the additional
  // timer interrupt that comes when the robot has backed off. Throws ProgramFault.
  Reply send_turn(const Outcome& outcome);
  // Says that send_turn() comes soon.
  void fetch_memory(int robot) const { memory_.fetch(robot); }

  // Off: dark, deaf and still. On again: as after power-up; only between ticks. Throws ProgramFault.
  void set_power(int robot, bool on);
  bool powered(int robot) const { return cells_[index(robot)].state != State::off; }
  // From now on a robot in deep sleep hears only what is on the air when it wakes. Else a fleet command is taken to be
  // repeated until everybody has heard it.
  void nothing_is_repeated() { repeats_ = false; }
  // As in the robot's EEPROM.
  std::uint16_t id_of(int robot) const { return uid_[index(robot)]; }
  const BootLoader& loader(int robot) const { return loaders_[index(robot)]; }

  FaultGuard& guard() { return *guard_; }

  // For tests: a robot's own copy of a variable of the library.
  std::uint32_t ticks(int robot) const;
  std::uint64_t stacks_in_use() const { return waiting_; }

 private:
  friend struct RobotServices;
  enum class State : std::uint8_t { idle, running, sleeping, battery, charging, moving, loader, off };
  enum class Phase : std::uint8_t { enter, messages, tick, run, leave };
  // All that a quiet turn looks at, in one line of the cache.
  struct alignas(64) Cell {
    void* context = nullptr;                     // of a program that waits; null: none does
    const WorkerStacks::Stack* stack = nullptr;  // it waits on
    std::int64_t wake_us = 0;                    // lab time at which its wait ends
    std::int64_t frozen_us = 0;                  // time that a callback spent waiting: interrupts are off
    std::int64_t slept_at = 0;                   // tick in which deep sleep began
    State state = State::idle, shown = State::idle;
    bool has_setup = false, reset = false;
    // Its program has turns; not any more once it has heard RESET.
    bool runs() const { return state == State::running && !reset; }
    std::uint16_t busy_ticks = 0;   // in a row that its program only computed
    std::uint16_t send_clock = 0;   // timer counts since the last message, as on the robot: wraps
    std::uint8_t heard_asleep = 0;  // fleet command waiting for the next wake-up
    std::uint8_t motion = 0;        // state moving: 0 none, 1 left, 2 right, 3 straight
  };

  static constexpr std::uint16_t clock_per_tick = 255;
  struct Clock {
    std::int64_t at_us = 0;    // after the start of the present tick
    std::int64_t late_us = 0;  // that each tick of it takes longer than it should
  };

  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }
  bool receiving() const {
    return !booting_ && sensors_.receiving && sensors_.receiving(robot_, tick_ * tick_us + cursor_us_);
  }
  void power_up(int robot);
  void forget_program(Cell& cell);
  void run_clock();
  [[noreturn]] void report(const Fault& fault);

  // the walk over robots
  void* new_worker();
  void worker();
  void walk();
  bool enter();
  bool deliver_next();
  void take_command(const Message& message);
  void change_state(State state);
  void show_state();
  void run_program();
  [[noreturn]] void resume();
  void wait(std::int64_t us);
  void busy_at(const void* from, bool wakeable);
  void wait_for_tick(const void* from);
  void busy_in_callback(const void* from);
  void call(void (*function)(void));

  static RobotHost* running_;  // whose robots have their turn; programs call back without saying for whom

  std::shared_ptr<const RobotProgram> program_;
  const arkmesh_program& abi_;
  int count_;
  Motors& motors_;
  LedLights& leds_;
  Sensors sensors_;
  std::shared_ptr<FaultGuard> guard_;
  RobotMemory memory_;
  std::vector<Cell> cells_;
  std::vector<std::uint16_t> uid_;
  std::vector<BootLoader> loaders_;
  bool repeats_ = true;
  std::vector<std::int16_t> voltage_, temperature_;  // by robot
  std::vector<std::uint8_t> boot_phase_;             // ticks that a robot was on before lab time 0
  std::vector<hal::RandomStream> hard_random_;
  std::vector<Clock> clocks_;
  bool clocks_differ_;
  std::vector<Offer> offers_;
  std::vector<int> resets_;

  // the walk's place; outside any stack, because the walk moves from stack to stack
  WorkerStacks stacks_;
  const WorkerStacks::Stack* stack_ = nullptr;  // the walk is on
  void* scheduler_ = nullptr;                   // context that waits for the walk's end
  StackBounds scheduler_stack_;
  void* worker_ = nullptr;    // context that waits for the next walk
  void** save_to_ = nullptr;  // where the context that was left is to be kept
  void* scrap_ = nullptr;
  const Inbox* inbox_ = nullptr;
  std::int64_t tick_ = 0;
  int robot_ = 0;
  Phase phase_ = Phase::enter;
  std::size_t next_overhead_ = 0, next_infrared_ = 0, past_infrared_ = 0;
  std::uint32_t beats_ = 1;     // of the robot's timer in this tick
  std::int64_t cursor_us_ = 0;  // of the robot, after the start of the tick
  bool ran_ = false, delayed_ = false, in_callback_ = false, booting_ = false;
  int callback_busy_ = 0;  // times that the present callback has computed for a tick
  std::uint64_t waiting_ = 0;
  Outcome outcome_{};  // of the present send turn
  Reply reply_;
};

}  // namespace arkmesh::sim_ode
