// How a program's waits become lab time: in delay(), in loops that only compute, and in loops that watch the clock. A
// wait past the end of a tick leaves its stack to the robot, see turns.cpp.
#include <algorithm>
#include <new>
#include <utility>

#include "sim_ode/host/turns/turns.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr int max_busy_ticks = 244;  // 8 s in which a program calls nothing: it never returns

}  // namespace

// The program has computed for a tick: it gets the rest of its time in the next one. It hangs when it has done nothing
// else for long and nothing can interrupt it: it has no callbacks, or runs in one.
void Turns::busy_at(const void* from, bool wakeable) {
  if (booting_) return;
  if (in_callback_) return busy_in_callback(from);
  Cell& cell = cells_[index(robot_)];
  if (wakeable || *abi_.reads > 0) cell.busy_ticks = 0;
  if (++cell.busy_ticks > max_busy_ticks) FaultGuard::leave(Fault::Kind::hang, nullptr, from);
  wait(std::max<std::int64_t>(1, tick_us - cursor_us_), from);
}

void Turns::busy_in_callback(const void* from) {
  if (++callback_busy_ > max_busy_ticks) FaultGuard::leave(Fault::Kind::hang, nullptr, from);
}

// The program has read the clock or a sensor so often that it waits for a change; in a callback the clock stands still.
void Turns::wait_for_tick(const void* from) {
  if (booting_) {
    // main() waits before kilo_start(): power-up lies before lab time 0
    *abi_.ticks = *abi_.ticks + 1;
    note('k', static_cast<std::uint32_t>(tick_), *abi_.ticks);
    return;
  }
  if (in_callback_) return busy_in_callback(from);
  wait(std::max<std::int64_t>(1, tick_us - cursor_us_), from);
}

// The program whose turn it is drives, stops or changes its LED; `seen`: to something else than nothing.
void Turns::acts(bool seen) {
  if (seen) acted_[index(robot_)] = 1;
  if (!booting_ && cells_[index(robot_)].waited) waits_[index(robot_)].since_us = now_us();
}

std::vector<Turns::Wait> Turns::idle_waits(std::int64_t least_us) const {
  std::vector<Wait> out;
  for (std::size_t i = 0; i < cells_.size(); ++i)
    if (cells_[i].context && cells_[i].firmware.has_setup() && tick_ * tick_us - waits_[i].since_us >= least_us)
      out.push_back(waits_[i]);
  return out;
}

// The program whose turn it is lets `us` pass. Returns when they have.
void Turns::wait(std::int64_t us, const void* from) {
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

  // leave this stack to the robot; the walk goes on at this robot's next phase
  Cell& cell = cells_[index(robot_)];
  cell.wake_us = tick_ * tick_us + cursor_us_;
  cell.stack = stack_;
  if (!std::exchange(cell.waited, true))
    waits_[index(robot_)] = {.robot = robot_, .since_us = now_us() - us, .from = nullptr};
  waits_[index(robot_)].from = from;
  cursor_us_ = tick_us;
  ++waiting_;
  FaultGuard::leave_program();
  try {
    stack_ = stacks_.take();
  } catch (const std::bad_alloc&) {
    FaultGuard::leave(Fault::Kind::gave_up,
                      "waits in delay(), but the system lacks memory for another waiting program");
  }
  leave_for_caller(&cell.context);
  *abi_.reads = 0;
  FaultGuard::enter_program();
}

}  // namespace arkmesh::sim_ode
