// Programs run on stacks of their own, so that one that damages its stack harms nothing else. When a program waits past
// the end of a tick, its stack stays with it, and the next one is called on another.
#include "sim_ode/host/turns/turns.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "sim_ode/host/turns/robot_services.hpp"

namespace arkmesh::sim_ode {

Turns* Turns::running_ = nullptr;

Turns::Turns(const arkmesh_program& program, RobotMemory& memory, RobotHeaps& heaps, RobotFiles& files,
             RobotBodies& bodies, FaultGuard& guard, std::vector<RobotClock> clocks, std::vector<SendTimer> timers,
             bool clocks_differ, ProgramText* text, TurnLog* log)
    : abi_(program),
      memory_(memory),
      heaps_(heaps),
      files_(files),
      bodies_(bodies),
      guard_(guard),
      text_(text),
      log_(log),
      count_(static_cast<int>(clocks.size())),
      cells_(clocks.size()),
      waits_(clocks.size()),
      acted_(clocks.size()),
      loaders_(clocks.size()),
      clocks_(std::move(clocks)),
      timers_(std::move(timers)),
      clocks_differ_(clocks_differ),
      stack_(stacks_.take()) {
  *abi_.host = RobotServices::all();
}

RobotValues Turns::read_values() const {
  return {*abi_.uid, {*abi_.turn_left, *abi_.turn_right, *abi_.straight_left, *abi_.straight_right}};
}

void Turns::write_values(const RobotValues& values) {
  *abi_.uid = values.uid;
  *abi_.turn_left = values.duties.turn_left;
  *abi_.turn_right = values.duties.turn_right;
  *abi_.straight_left = values.duties.straight_left;
  *abi_.straight_right = values.duties.straight_right;
}

Fault Turns::boot(int robot) {
  start_anew(robot);
  if (heaps_.in_use()) heaps_.forget(robot);
  write_values(bodies_.values(robot));
  std::copy(high_gain_table.begin(), high_gain_table.end(), abi_.irhigh);
  std::copy(low_gain_table.begin(), low_gain_table.end(), abi_.irlow);
  if (bodies_.by_argos()) {  // readings are millimetres, which a table of zeros says; a period is, too
    std::fill_n(abi_.irlow, low_gain_table.size(), std::uint16_t{0});
    *abi_.tx_period = 100;
  }
  cells_[index(robot)] = {};
  bodies_.stop(robot);
  robot_ = robot;
  cursor_us_ = 0;
  booting_ = true;
  running_ = this;
  if (log_) {
    const RobotValues values = read_values();
    note('I', values.uid, values.duties);
    log_->put_bytes(bodies_.number(robot), abi_.irhigh, sizeof high_gain_table);
    log_->put_bytes(bodies_.number(robot), abi_.irlow, sizeof low_gain_table);
    log_->put_bytes(bodies_.number(robot), abi_.eeprom ? abi_.eeprom : std::vector<std::uint8_t>(1024).data(), 1024);
  }
  const Fault fault = run([](void* self) { static_cast<Turns*>(self)->call(static_cast<Turns*>(self)->abi_.main); });
  booting_ = false;
  memory_.copy_out(robot);
  return fault;
}

void Turns::switch_off(int robot) {
  forget_program(cells_[index(robot)]);
  cells_[index(robot)] = {};
  cells_[index(robot)].firmware = Firmware(Firmware::State::off);
  bodies_.stop(robot);
}

// Whatever its program was doing.
void Turns::forget_program(Cell& cell) {
  if (!cell.context) return;
  note('F');
  stacks_.give(cell.stack);
  --waiting_;
  cell.context = nullptr;
}

Fault Turns::walk(std::int64_t number, const Inbox& inbox) {
  tick_ = number;
  inbox_ = &inbox;
  offers_.clear();
  resets_.clear();
  robot_ = 0;
  phase_ = Phase::enter;
  next_infrared_ = 0;
  return run_walk();
}

Fault Turns::run(void (*work)(void*)) {
  running_ = this;
  Fault fault = guard_.run(work, this);
  if (fault.kind == Fault::Kind::none) return fault;
  jumped_back();
  forget_frames(stack_->bounds());
  return fault;
}

Fault Turns::walk_on_without_robot() {
  give_up_robot();
  ++robot_;
  phase_ = Phase::enter;
  return run_walk();
}

void Turns::give_up_robot() {
  in_callback_ = false;
  switch_off(robot_);
}

Fault Turns::run_walk() {
  return run([](void* self) { static_cast<Turns*>(self)->walk_on(); });
}

[[gnu::always_inline]] inline void Turns::leave() {
  const std::size_t i = index(robot_);
  Cell& cell = cells_[i];
  if (!cell.context) main_loop(cell);
  cell.firmware.count(beats_);
  const bool talks = *abi_.tx && *abi_.tx != abi_.no_tx;
  if (beats_ > 0 && talks && (bodies_.by_argos() ? cell.firmware.talks() : cell.firmware.due(*abi_.tx_period)))
    offers_.push_back({robot_, timers_[i].at_us(clocks_[i].at_us), *abi_.tx_period});
  memory_.copy_out(robot_);
}

// The program has returned from what it was called for.
void Turns::log_end(std::span<const std::byte> result) {
  if (!log_) [[likely]]
    return;
  note('R', static_cast<std::uint8_t>(result.size()));
  log_->put_bytes(bodies_.number(robot_), result.data(), result.size());
  log_memory();
}

// Calls setup() or loop() once, which may wait past the tick.
[[gnu::always_inline]] inline void Turns::run_program() {
  Cell& cell = cells_[index(robot_)];
  --loops_left_;
  delayed_ = false;
  cell.busy_ticks = 0;
  cell.waited = false;
  *abi_.reads = *abi_.blocks = 0;
  const bool loops = cell.firmware.has_setup();
  if (loops) cell.firmware.calls_loop();
  note(loops ? 'L' : 'S');
  call(loops ? *abi_.loop : *abi_.setup);
  if (!cell.context) program_returned(cell);
}

[[gnu::always_inline]] inline void Turns::program_returned(Cell& cell) {
  log_end();
  if (cell.firmware.has_setup()) return;
  cell.firmware.setup_is_done();
  // loop follows at once
  if (cell.firmware.runs() && cursor_us_ < tick_us) delayed_ = true;
}

// The program whose turn it is goes on from its wait, until it returns or waits again.
void Turns::resume() {
  Cell& cell = cells_[index(robot_)];
  cursor_us_ = cell.wake_us - tick_ * tick_us;
  loops_left_ = 0;
  delayed_ = true;
  --waiting_;
  stacks_.give(stack_);
  stack_ = std::exchange(cell.stack, nullptr);
  called_ = reinterpret_cast<void*>(cell.firmware.has_setup() ? *abi_.loop : *abi_.setup);
  resume_on(stack_->bounds(), std::exchange(cell.context, nullptr));
  FaultGuard::leave_program();
  if (!cell.context) program_returned(cell);
}

// From the present robot's present phase to the end of the tick.
void Turns::walk_on() {
  for (;;) {
    switch (phase_) {
      case Phase::enter:
        walk_quiet();
        if (phase_ == Phase::run) break;
        if (robot_ == count_) return;
        if (!enter()) {
          ++robot_;
          break;
        }
        phase_ = Phase::messages;
        [[fallthrough]];
      case Phase::messages:
        if (deliver_next()) {
          // a robot runs loop thousands of times in a tick, so it sees each message by itself
          const Cell& cell = cells_[index(robot_)];
          if (cell.firmware.runs() && cell.firmware.has_setup() && !cell.context) run_program();
          break;
        }
        phase_ = Phase::tick;
        [[fallthrough]];
      case Phase::tick: {
        const Cell& cell = cells_[index(robot_)];
        if (cell.firmware.resets()) {
          phase_ = Phase::leave;
          break;
        }
        *abi_.ticks = *abi_.ticks + beats_;
        note('k', static_cast<std::uint32_t>(tick_), *abi_.ticks);
        phase_ = Phase::run;
        loops_left_ = loops_per_tick_;
        if (cell.context) {
          if (cell.wake_us < (tick_ + 1) * tick_us)
            resume();
          else
            phase_ = Phase::leave;
          break;
        }
        [[fallthrough]];
      }
      case Phase::run: {
        const Cell& cell = cells_[index(robot_)];
        // again in the same tick after a delay that did not last to its end
        const bool again = cursor_us_ < tick_us && (delayed_ || loops_left_ > 0);
        if (cell.firmware.runs() && !cell.context && (loops_left_ == loops_per_tick_ || again)) {
          run_program();
          break;
        }
        phase_ = Phase::leave;
        [[fallthrough]];
      }
      case Phase::leave:
        leave();
        ++robot_;
        phase_ = Phase::enter;
        break;
    }
  }
}

// The turns of robots that have nothing to do but loop, which are nearly all, up to one that has more; that one may be
// in phase run already. As the phases of walk_on() with nothing heard, no wait and no change of state, step by step.
void Turns::walk_quiet() {
  if (clocks_differ_ || loops_per_tick_ > 1 || !inbox_->overhead.empty()) return;
  while (robot_ < count_) {
    Cell& cell = cells_[index(robot_)];
    if (!cell.firmware.only_loops() || cell.context || cell.frozen_us > 0) return;
    while (next_infrared_ < inbox_->infrared.size() && inbox_->infrared[next_infrared_].robot < robot_)
      ++next_infrared_;
    if (next_infrared_ < inbox_->infrared.size() && inbox_->infrared[next_infrared_].robot == robot_) return;

    memory_.copy_in(robot_);
    *abi_.ticks = *abi_.ticks + 1;
    note('k', static_cast<std::uint32_t>(tick_), *abi_.ticks);
    cursor_us_ = 0;
    loops_left_ = loops_per_tick_;
    phase_ = Phase::run;
    run_program();
    if (delayed_) return;
    leave();
    ++robot_;
    phase_ = Phase::enter;
  }
}

// False when the robot's clock stands still in this tick.
bool Turns::enter() {
  Cell& cell = cells_[index(robot_)];
  if (cell.firmware.state() == Firmware::State::off) return false;
  cursor_us_ = 0;
  next_overhead_ = 0;
  if (clocks_differ_) beats_ = clocks_[index(robot_)].next_tick();
  while (next_infrared_ < inbox_->infrared.size() && inbox_->infrared[next_infrared_].robot < robot_) ++next_infrared_;
  past_infrared_ = next_infrared_;
  while (past_infrared_ < inbox_->infrared.size() && inbox_->infrared[past_infrared_].robot == robot_) ++past_infrared_;

  if (cell.firmware.sleeps() && !cell.context) {
    // what the controller says is repeated until somebody wakes to hear it
    if (!repeats_) cell.firmware.say_asleep(0);
    for (const Inbox::Overhead& heard : inbox_->overhead)
      if (heard.message.type > 127 && (repeats_ || heard.reaches(robot_))) cell.firmware.say_asleep(heard.message.type);
    Message command;
    command.type = cell.firmware.wake(tick_);
    if (command.type == 0) return false;
    memory_.copy_in(robot_);
    hear(command);
    next_overhead_ = inbox_->overhead.size();
    next_infrared_ = past_infrared_;
    return true;
  }
  if (cell.frozen_us > 0) {
    if (cell.frozen_us >= tick_us) {
      cell.frozen_us -= tick_us;
      return false;
    }
    cursor_us_ = std::exchange(cell.frozen_us, 0);
  }
  memory_.copy_in(robot_);
  if (robot_ + 1 < count_) memory_.fetch(robot_ + 1);
  return true;
}

// What the firmware does from its main loop, once loop has returned.
void Turns::main_loop(Cell& cell) {
  const std::int64_t us = std::min(cursor_us_, tick_us - 1);
  switch (cell.firmware.state()) {
    case Firmware::State::moving:
      cell.firmware.steer(us, read_values(), [this](Duties duties, std::int64_t at_us) {
        bodies_.drive(robot_, duties.left, duties.right, at_us);
      });
      break;
    case Firmware::State::idle:
      if (!cell.firmware.comes_round()) return;
      break;
    case Firmware::State::sleeping:
      cell.firmware.fall_asleep(tick_);
      break;
    case Firmware::State::loader:
      if (loaders_[index(robot_)].flashes()) bodies_.show(robot_, 0, us);
      break;
    default:
      break;
  }
  if (!cell.firmware.shows_another()) return;
  if (const auto colour = cell.firmware.show(bodies_.voltage(robot_))) bodies_.show(robot_, *colour, us);
}

}  // namespace arkmesh::sim_ode
