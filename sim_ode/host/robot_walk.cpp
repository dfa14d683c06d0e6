// RobotHost's walk over robots. It runs on worker stacks: when a program waits past the end of a tick, its stack stays
// with it and the walk goes on with another; when it is due, the walk moves onto that stack and goes on from there.
#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "sim_ode/host/robot_host.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr int most_busy_ticks = 244;  // 8 s in which a program calls nothing: it never returns
constexpr int sleep_ticks = 244;      // 8 s

}  // namespace

// Moves the walk onto a fresh stack; its worker starts when somebody switches to the context returned.
void* RobotHost::new_worker() {
  namespace context = boost::context::detail;
  stack_ = stacks_.take();
  return context::make_fcontext(stack_->top, stack_->bytes, [](context::transfer_t from) {
    auto* const host = static_cast<RobotHost*>(from.data);
    const StackBounds left = arrived();
    if (host->save_to_ == &host->scheduler_) host->scheduler_stack_ = left;
    *host->save_to_ = from.fctx;
    host->worker();
  });
}

// A worker's life: a walk, or what is left of one, per tick. Never returns.
void RobotHost::worker() {
  for (;;) {
    walk();
    void* const from = switch_to(scheduler_, scheduler_stack_, nullptr);
    *save_to_ = from;
  }
}

void RobotHost::walk() {
  for (;;) {
    switch (phase_) {
      case Phase::enter:
        if (robot_ == count_) return;
        if (!enter()) {
          ++robot_;
          break;
        }
        phase_ = Phase::messages;
        [[fallthrough]];
      case Phase::messages: {
        if (deliver_next()) {
          // a robot runs loop thousands of times in a tick, so it sees each message by itself
          const Cell& cell = cells_[index(robot_)];
          if (cell.runs() && cell.has_setup && !cell.context) run_program();
          break;
        }
        phase_ = Phase::tick;
        [[fallthrough]];
      }
      case Phase::tick: {
        Cell& cell = cells_[index(robot_)];
        if (cell.reset) {
          phase_ = Phase::leave;
          break;
        }
        *abi_.ticks = *abi_.ticks + beats_;
        phase_ = Phase::run;
        ran_ = false;
        if (cell.context) {
          if (cell.wake_us < (tick_ + 1) * tick_us) resume();
          phase_ = Phase::leave;
          break;
        }
        [[fallthrough]];
      }
      case Phase::run: {
        const Cell& cell = cells_[index(robot_)];
        // again in the same tick after a delay that did not last to its end
        if (cell.state == State::running && !cell.context && (!ran_ || (delayed_ && cursor_us_ < tick_us))) {
          run_program();
          break;
        }
        phase_ = Phase::leave;
        [[fallthrough]];
      }
      case Phase::leave: {
        const std::size_t i = index(robot_);
        Cell& cell = cells_[i];
        if (cell.shown != cell.state && !cell.context) show_state();
        cell.send_clock = static_cast<std::uint16_t>(cell.send_clock + clock_per_tick * beats_);
        const bool talks = *abi_.tx && *abi_.tx != abi_.no_tx;
        if (beats_ > 0 && cell.send_clock > *abi_.tx_period && cell.runs() && talks)
          offers_.push_back({robot_, clocks_[i].at_us});
        memory_.copy_out(robot_);
        ++robot_;
        phase_ = Phase::enter;
        break;
      }
    }
  }
}

// A slow timer's moment comes later in each tick, until one has none; a fast one's earlier, until one has two.
void RobotHost::run_clock() {
  Clock& clock = clocks_[index(robot_)];
  clock.at_us += clock.late_us;
  beats_ = 1;
  if (clock.at_us >= tick_us) {
    clock.at_us -= tick_us;
    beats_ = 0;
  } else if (clock.at_us < 0) {
    clock.at_us += tick_us;
    beats_ = 2;
  }
}

// False when the robot's clock stands still in this tick.
bool RobotHost::enter() {
  Cell& cell = cells_[index(robot_)];
  if (cell.state == State::off) return false;
  cursor_us_ = 0;
  next_overhead_ = 0;
  if (clocks_differ_) run_clock();
  while (next_infrared_ < inbox_->infrared.size() && inbox_->infrared[next_infrared_].robot < robot_) ++next_infrared_;
  past_infrared_ = next_infrared_;
  while (past_infrared_ < inbox_->infrared.size() && inbox_->infrared[past_infrared_].robot == robot_) ++past_infrared_;

  if (cell.state == State::sleeping && !cell.context) {
    // deep sleep but for moments; what the controller says is repeated until somebody wakes to hear it
    if (!repeats_) cell.heard_asleep = 0;
    for (const Inbox::Overhead& heard : inbox_->overhead)
      if (heard.message.type > 127 && (repeats_ || heard.missed.empty() || !heard.missed[index(robot_)]))
        cell.heard_asleep = heard.message.type;
    if (cell.heard_asleep == 0 || (tick_ - cell.slept_at) % sleep_ticks != 0) return false;
    memory_.copy_in(robot_);
    Message command;
    command.type = std::exchange(cell.heard_asleep, std::uint8_t{0});
    take_command(command);
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

// Delivers the oldest message that the robot has not had yet. False when there is none.
bool RobotHost::deliver_next() {
  while (next_overhead_ < inbox_->overhead.size() && !inbox_->overhead[next_overhead_].missed.empty() &&
         inbox_->overhead[next_overhead_].missed[index(robot_)])
    ++next_overhead_;
  const bool overhead = next_overhead_ < inbox_->overhead.size(), infrared = next_infrared_ < past_infrared_;
  if ((!overhead && !infrared) || cells_[index(robot_)].reset) return false;

  const Message* message;
  std::int16_t low = 0, high = 0;
  if (infrared && (!overhead || inbox_->infrared[next_infrared_].at_us < inbox_->overhead[next_overhead_].at_us)) {
    const Reception& reception = inbox_->infrared[next_infrared_++];
    message = &reception.message;
    low = reception.low_gain;
    high = reception.high_gain;
  } else {
    message = &inbox_->overhead[next_overhead_++].message;
  }

  // one buffer for all messages, as on the robot
  std::memcpy(abi_.rx_message, message, sizeof *message);
  abi_.rx_distance[0] = low;
  abi_.rx_distance[1] = high;
  if (message->type > 127 || cells_[index(robot_)].state == State::loader) {
    take_command(*message);
    return true;
  }
  if (!*abi_.rx) return true;
  in_callback_ = true;
  callback_busy_ = 0;
  FaultGuard::enter_program();
  (*abi_.rx)(abi_.rx_message, abi_.rx_distance);
  FaultGuard::leave_program();
  in_callback_ = false;
  return true;
}

// Calls setup() or loop() once. May return many ticks later, on the same stack.
void RobotHost::run_program() {
  ran_ = true;
  delayed_ = false;
  cells_[index(robot_)].busy_ticks = 0;
  *abi_.reads = *abi_.blocks = 0;
  if (cells_[index(robot_)].has_setup) {
    call(*abi_.loop);
  } else {
    call(*abi_.setup);
    cells_[index(robot_)].has_setup = true;
    // loop follows at once
    if (cells_[index(robot_)].state == State::running && cursor_us_ < tick_us) delayed_ = true;
  }
}

void RobotHost::call(void (*function)(void)) {
  FaultGuard::enter_program();
  function();
  FaultGuard::leave_program();
}

// The program has computed for a tick: it gets the rest of its time in the next one. It hangs when it has done nothing
// else for long and nothing can interrupt it: it has no callbacks, or runs in one.
void RobotHost::busy_at(const void* from, bool wakeable) {
  if (booting_) return;
  if (in_callback_) return busy_in_callback(from);
  Cell& cell = cells_[index(robot_)];
  if (wakeable || *abi_.reads > 0) cell.busy_ticks = 0;
  if (++cell.busy_ticks > most_busy_ticks) FaultGuard::leave(Fault::Kind::hang, nullptr, from);
  wait(std::max<std::int64_t>(1, tick_us - cursor_us_));
}

void RobotHost::busy_in_callback(const void* from) {
  if (++callback_busy_ > most_busy_ticks) FaultGuard::leave(Fault::Kind::hang, nullptr, from);
}

// The program has read the clock or a sensor so often that it waits for a change; in a callback the clock stands still.
void RobotHost::wait_for_tick(const void* from) {
  if (booting_) {
    // main() waits before kilo_start(): power-up lies before lab time 0
    *abi_.ticks = *abi_.ticks + 1;
    return;
  }
  if (in_callback_) return busy_in_callback(from);
  wait(std::max<std::int64_t>(1, tick_us - cursor_us_));
}

// The program whose turn it is lets `us` pass. Returns when they have.
void RobotHost::wait(std::int64_t us) {
  if (us == 0 || booting_) return;
  if (in_callback_) {
    // interrupts are off: the robot stands still as a whole
    cells_[index(robot_)].frozen_us += us;
    return;
  }
  FaultGuard::note_progress();
  cursor_us_ += us;
  delayed_ = true;
  if (cursor_us_ < tick_us) return;

  // leave this stack to the robot; another worker goes on with the walk, at this robot's next phase
  Cell& cell = cells_[index(robot_)];
  cell.wake_us = tick_ * tick_us + cursor_us_;
  cell.stack = stack_;
  cursor_us_ = tick_us;
  ++waiting_;
  FaultGuard::leave_program();
  void* fresh;
  try {
    fresh = new_worker();
  } catch (const std::bad_alloc&) {
    FaultGuard::leave(Fault::Kind::gave_up,
                      "waits in delay(), but the system has no memory for one more waiting program");
  }
  save_to_ = &cell.context;
  void* const from = switch_to(fresh, stack_->bounds(), this);
  *save_to_ = from;
  *abi_.reads = 0;
  FaultGuard::enter_program();
}

// Moves the walk onto the stack of the robot whose turn it is. Does not return: the walk goes on from there.
void RobotHost::resume() {
  Cell& cell = cells_[index(robot_)];
  cursor_us_ = cell.wake_us - tick_ * tick_us;
  ran_ = delayed_ = true;
  --waiting_;
  stacks_.give(stack_);
  stack_ = std::exchange(cell.stack, nullptr);
  save_to_ = &scrap_;
  switch_to(std::exchange(cell.context, nullptr), stack_->bounds(), this);
  __builtin_unreachable();
}

}  // namespace arkmesh::sim_ode
