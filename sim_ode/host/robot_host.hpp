// Runs one Kilobot program on many robots, tick by tick, and tells why it cannot go on. Puts the parts together:
// bodies, memory, turns. Knows nothing of positions or of who hears whom.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim_ode/host/led_lights.hpp"
#include "sim_ode/host/motors.hpp"
#include "sim_ode/host/programs/robot_program.hpp"
#include "sim_ode/host/robot_bodies.hpp"
#include "sim_ode/host/robot_output.hpp"
#include "sim_ode/host/turns/fault_guard.hpp"
#include "sim_ode/host/turns/inbox.hpp"
#include "sim_ode/host/turns/robot_files.hpp"
#include "sim_ode/host/turns/robot_heaps.hpp"
#include "sim_ode/host/turns/robot_memory.hpp"
#include "sim_ode/host/turns/send_timer.hpp"
#include "sim_ode/host/turns/turns.hpp"

namespace arkmesh::sim_ode {

// A robot's program crashed, hangs, or gave up: one sentence naming robot, time and source line.
class ProgramFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class RobotHost {
 public:
  // Powers all robots up: main() runs until kilo_start(). `motors` and `leds` outlive the host. Robots' ids are 0, 1,
  // 2, ... unless `ids` holds others; their clocks are those of the motors' profiles. They are `robots` of the arena's
  // from number `first` on, and are counted from 0 here. Throws ProgramFault.
  RobotHost(std::shared_ptr<const RobotProgram> program, int robots, Motors& motors, LedLights& leds,
            RobotSensors sensors, const std::string& lab, std::uint64_t seed,
            const std::vector<std::uint16_t>& ids = {}, const RobotOutput& output = {}, int first = 0);

  // From now on a robot whose program fails stands still, dark and deaf, and the others go on. It fails all the same
  // where it boots.
  void leave_failed_robots() { leave_failed_ = true; }
  // From now on loop is called so often in a tick, unless it waits.
  void call_loop(int times_per_tick) { turns_.call_loop(times_per_tick); }
  std::uint64_t failed_robots() const { return failed_robots_; }
  // Robots that once stood and showed nothing new for 5 s, in one call of `loop`.
  std::uint64_t waited_robots() const { return waited_.size(); }
  // How often a program wrote beyond what malloc() gave, or gave back what it did not have.
  std::uint64_t heap_misuse() const { return heap_misuse_; }
  // All robots' turns for tick `number` (1, 2, ...). Throws ProgramFault, which ends the host's use.
  void tick(std::int64_t number, const Inbox& inbox);

  // Robots whose timer comes in the present tick with something to send, perhaps. Ascending.
  std::span<const Offer> offers() const { return turns_.offers(); }
  // The robot's turn when its moment has come. Calls kilo_message_tx and, when the channel is free, so that the message
  // goes out undisturbed, kilo_message_tx_success; the robot's send timer starts anew. Otherwise counts the additional
  // timer interrupt that comes when the robot has backed off. Throws ProgramFault.
  Reply send_turn(const Outcome& outcome);
  // Says that send_turn() comes soon.
  void fetch_memory(int robot) const { memory_.fetch(robot); }

  // Off: dark, deaf and still. On again: as after power-up; only between ticks. Throws ProgramFault.
  void set_power(int robot, bool on);
  bool powered(int robot) const { return turns_.firmware(robot).state() != Firmware::State::off; }
  // As Firmware::shown_after().
  std::optional<std::uint8_t> shown_after(int robot, std::uint8_t type) const {
    return turns_.firmware(robot).shown_after(type, bodies_.voltage(robot));
  }
  // As Turns::nothing_is_repeated().
  void nothing_is_repeated() { turns_.nothing_is_repeated(); }
  // As Turns::hear_overhead_at().
  void hear_overhead_at(double distance_m) {
    overhead_is_assumed_ = distance_m == assumed_overhead_m;
    turns_.hear_overhead_at(distance_m);
  }
  // As in the robot's EEPROM.
  std::uint16_t id_of(int robot) const;
  const BootLoader& loader(int robot) const { return turns_.loader(robot); }

  // At the end of a run: says how many robots did nothing that could be seen, and what rests on an assumption, if any.
  void tell_at_end() const;

  FaultGuard& guard() { return *guard_; }

  // For tests: a robot's own copy of a variable of the library.
  std::uint32_t ticks(int robot) const { return memory_.read(robot, program_->abi().ticks); }
  std::uint64_t stacks_in_use() const { return turns_.stacks_in_use(); }

 private:
  void power_up(int robot);
  [[noreturn]] void report(const Fault& fault) const;
  void leave_or_report(const Fault& fault);
  void tell_of_idle_waits();
  void tell_of_heap_misuse();
  std::string sentence_for(const Fault& fault) const;
  std::string words_for(const Fault& fault, const std::string& place) const;

  std::shared_ptr<const RobotProgram> program_;
  std::shared_ptr<FaultGuard> guard_;
  RobotBodies bodies_;
  RobotHeaps heaps_;
  RobotFiles files_;
  RobotMemory memory_;
  Turns turns_;
  int robots_;
  bool leave_failed_ = false, overhead_is_assumed_ = false;
  std::set<int> waited_;
  int told_of_idle_ = 0;  // times
  std::uint64_t failed_robots_ = 0, heap_misuse_ = 0;
  std::set<const void*> told_places_;
};

}  // namespace arkmesh::sim_ode
