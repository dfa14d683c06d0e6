// Robots' turns: gives each robot its own memory in turn, delivers what it heard, lets its clock tick, calls its
// program and carries out what the firmware says. A program that waits past the end of a tick keeps a stack of its own
// meanwhile; others share one. All program code runs in here, guarded.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "sim_ode/host/programs/program_text.hpp"
#include "sim_ode/host/robot_bodies.hpp"
#include "sim_ode/host/turns/boot_loader.hpp"
#include "sim_ode/host/turns/distance_readings.hpp"
#include "sim_ode/host/turns/fault_guard.hpp"
#include "sim_ode/host/turns/firmware.hpp"
#include "sim_ode/host/turns/inbox.hpp"
#include "sim_ode/host/turns/program_stacks.hpp"
#include "sim_ode/host/turns/robot_clock.hpp"
#include "sim_ode/host/turns/robot_files.hpp"
#include "sim_ode/host/turns/robot_heaps.hpp"
#include "sim_ode/host/turns/robot_memory.hpp"
#include "sim_ode/host/turns/send_timer.hpp"
#include "sim_ode/host/turns/turn_log.hpp"
#include "sim_ode/kilolib/robot_abi.h"

namespace arkmesh::sim_ode {

class Turns {
 public:
  // Everything given outlives the turns. One clock for each robot; they are run when they differ. `text` is null when
  // nobody listens to what programs print, `log` when nobody wants to know what happens to them.
  Turns(const arkmesh_program& program, RobotMemory& memory, RobotHeaps& heaps, RobotFiles& files, RobotBodies& bodies,
        FaultGuard& guard, std::vector<RobotClock> clocks, std::vector<SendTimer> timers, bool clocks_differ,
        ProgramText* text, TurnLog* log);
  Turns(const Turns&) = delete;
  Turns& operator=(const Turns&) = delete;

  // Each of these returns why it ended early: then robot() and now_us() say in whose turn and when. The turns are of no
  // more use then, unless that robot is given up.

  // Before a robot's first power-up: what its EEPROM comes with.
  void write_eeprom(int robot);
  // Power-up: fresh memory but for the EEPROM, values from the EEPROM, main() up to kilo_start(), with which it ends
  // (Fault::Kind::left).
  Fault boot(int robot);
  // All robots' turns for tick `number` (1, 2, ...).
  Fault walk(std::int64_t number, const Inbox& inbox);
  // After a fault in walk(): that robot is given up, and the others' turns go on.
  Fault walk_on_without_robot();
  // After a fault: the robot whose turn it was is switched off.
  void give_up_robot();
  // A robot's turn when the moment of its send timer has come.
  Fault send(const Outcome& outcome, Reply& reply);

  // Of the last walk: robots whose send timer comes, ascending, and robots to be booted.
  std::span<const Offer> offers() const { return offers_; }
  const std::vector<int>& resets() const { return resets_; }

  void switch_off(int robot);
  Firmware& firmware(int robot) { return cells_[index(robot)].firmware; }
  const Firmware& firmware(int robot) const { return cells_[index(robot)].firmware; }
  BootLoader& loader(int robot) { return loaders_[index(robot)]; }
  const BootLoader& loader(int robot) const { return loaders_[index(robot)]; }
  // From now on a robot in deep sleep hears only what is on the air when it wakes. Else a fleet command is taken to be
  // repeated until everybody has heard it.
  void nothing_is_repeated() { repeats_ = false; }
  // What robots measure of the overhead controller's light from now on.
  void hear_overhead_at(double distance_m) {
    overhead_ = bodies_.by_argos() ? DistanceReadings{0, 0} : readings_at(distance_m);
  }
  void call_loop(int times_per_tick) { loops_per_tick_ = times_per_tick; }

  // A program that waits in a call of `loop` that has lasted for long.
  struct Wait {
    int robot = 0;
    std::int64_t since_us = 0;   // lab time since when it has done nothing: neither returned nor set motors or LED
    const void* from = nullptr;  // where it waits; null: not known
  };
  // A program asked for the distance of what it heard of the overhead controller.
  bool measures_overhead() const { return measures_overhead_; }
  // How many robots have neither driven, nor sent, nor changed their LED once they were set up.
  std::size_t idle_robots() const { return static_cast<std::size_t>(std::ranges::count(acted_, char{0})); }
  // Those that have done nothing for so long, ascending by robot. Between walks.
  std::vector<Wait> idle_waits(std::int64_t least_us) const;

  int robot() const { return robot_; }
  std::int64_t tick() const { return tick_; }
  // Lab time of the robot whose turn it is.
  std::int64_t now_us() const { return tick_ * tick_us + (booting_ ? 0 : cursor_us_); }
  // Whether an address lies below or above the stack of the program whose turn it was.
  bool is_below_stack(const void* address) const { return stack_->fence_at(address) < 0; }
  bool is_above_stack(const void* address) const { return stack_->fence_at(address) > 0; }
  // The function of the program that was called last: main, setup, loop or a callback.
  const void* called() const { return called_; }
  std::uint64_t stacks_in_use() const { return waiting_; }

 private:
  friend struct RobotServices;
  enum class Phase : std::uint8_t { enter, messages, tick, run, leave };
  // All that a quiet turn looks at, in one line of the cache.
  struct alignas(64) Cell {
    void* context = nullptr;                      // of a program that waits; null: none does
    const ProgramStacks::Stack* stack = nullptr;  // it waits on
    std::int64_t wake_us = 0;                     // lab time at which its wait ends
    std::int64_t frozen_us = 0;                   // time that a callback spent waiting: interrupts are off
    Firmware firmware;
    std::uint16_t busy_ticks = 0;  // in a row that its program only computed
    bool waited = false;           // past a tick, in this call of setup or loop
  };
  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }

  void start_anew(int robot);
  void save(const RobotValues& values);
  Fault run(void (*work)(void*));
  Fault run_walk();
  void walk_on();
  void walk_quiet();
  bool enter();
  bool deliver_next();
  void hear(const Message& command);
  void main_loop(Cell& cell);
  void leave();
  void run_program();
  void program_returned(Cell& cell);
  void ask_for_message();
  void resume();
  void forget_program(Cell& cell);
  void log_memory() { log_->put_memory(bodies_.number(robot_), abi_.begin, abi_.end); }
  void log_end(std::span<const std::byte> result = {});
  template <class... Values>
  void note(char letter, Values... values) {
    if (log_) [[unlikely]]
      log_->put(bodies_.number(robot_), letter, values...);
  }
  template <class Function>
  void* call(Function function, void* a = nullptr, void* b = nullptr) {
    called_ = reinterpret_cast<void*>(function);
    FaultGuard::enter_program();
    void* const result = call_on(stack_->bounds(), called_, a, b);
    FaultGuard::leave_program();
    return result;
  }
  template <class Call>
  void call_back(Call call);
  RobotValues read_values() const;
  void write_values(const RobotValues& values);

  // What programs ask for.
  void wait(std::int64_t us, const void* from);
  void acts(bool seen);
  bool has_setup() const { return cells_[index(robot_)].firmware.has_setup(); }
  void busy_at(const void* from, bool wakeable);
  void wait_for_tick(const void* from);
  void busy_in_callback(const void* from);

  static Turns* running_;  // whose robots have their turn; programs call back without saying for whom

  const arkmesh_program abi_;
  RobotMemory& memory_;
  RobotHeaps& heaps_;
  RobotFiles& files_;
  RobotBodies& bodies_;
  FaultGuard& guard_;
  ProgramText* text_;
  TurnLog* log_;
  int count_;
  std::vector<Cell> cells_;
  std::vector<Wait> waits_;
  std::vector<char> acted_;
  std::vector<BootLoader> loaders_;
  std::vector<RobotClock> clocks_;
  std::vector<SendTimer> timers_;
  bool clocks_differ_, repeats_ = true, measures_overhead_ = false;
  DistanceReadings overhead_{};
  std::vector<Offer> offers_;
  std::vector<int> resets_;

  ProgramStacks stacks_;
  const ProgramStacks::Stack* stack_;  // of the program whose turn it is
  void* called_ = nullptr;
  // the walk's place
  const Inbox* inbox_ = nullptr;
  std::int64_t tick_ = 0;
  int robot_ = 0;
  Phase phase_ = Phase::enter;
  std::size_t next_overhead_ = 0, next_infrared_ = 0, past_infrared_ = 0;
  unsigned beats_ = 1;                       // of the robot's timer in this tick
  std::int64_t cursor_us_ = 0;               // of the robot, after the start of the tick
  int loops_per_tick_ = 1, loops_left_ = 0;  // in this tick
  bool delayed_ = false, in_callback_ = false, booting_ = false;
  int callback_busy_ = 0;  // times that the present callback has computed for a tick
  std::uint64_t waiting_ = 0;
  Outcome outcome_{};  // of the present send turn
  Reply* reply_ = nullptr;
};

}  // namespace arkmesh::sim_ode
