// The walk over robots runs on worker stacks. When a program waits past the end of a tick, its stack stays with it and the
// walk goes on with another; when it is due, the walk moves onto that stack and goes on from there.
#include "sim_ode/robot_host.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <new>
#include <utility>

#include "hal/arena_config.hpp"

namespace arkmesh::sim_ode {
namespace {

// The host whose robots have their turn. Programs call back without saying for whom.
RobotHost* running = nullptr;

// Battery and temperature: Kilombo's values, and how far a robot's may lie off them (our assumption).
constexpr int nominal_voltage = 876, voltage_spread = 30, nominal_temperature = 314, temperature_spread = 4;
constexpr int most_busy_ticks = 244;        // 8 s in which a program calls nothing: it never returns
constexpr int sleep_ticks = 244;            // 8 s
constexpr std::uint16_t clock_per_tick = 255;
// Gap of k x 5 mm: readings of a typical robot.
constexpr std::uint16_t high_table[14] = {1000, 930, 860, 790, 720, 650, 585, 525, 470, 420, 375, 335, 300, 270};
constexpr std::uint16_t low_table[14] = {900, 640, 500, 400, 330, 275, 232, 198, 170, 147, 128, 112, 98, 86};

// Offset of a variable in a robot's memory.
template <class T>
std::size_t offset(const arkmesh_program& abi, const volatile T* variable) {
  return static_cast<std::size_t>(reinterpret_cast<const volatile char*>(variable) - abi.begin);
}

}  // namespace

// What programs ask of the host.
struct RobotServices {
  static RobotHost& host() { return *running; }
  static void wait_us(std::uint32_t us) { host().wait(us + us * host().clocks_[RobotHost::index(host().robot_)].late_us / tick_us); }
  static void wait_for_tick(const void* from) { host().wait_for_tick(from); }
  static void motors(std::uint8_t left, std::uint8_t right) { host().motors_.set(host().robot_, left, right, host().cursor_us_); }
  static void colour(std::uint8_t colour) { host().leds_.set(host().robot_, colour, host().cursor_us_); }
  static std::int16_t light() {
    if (host().receiving()) return -1;
    return host().sensors_.light ? host().sensors_.light(host().robot_) : std::int16_t{0};
  }
  static std::int16_t voltage() { return host().receiving() ? std::int16_t{-1} : host().voltage_[RobotHost::index(host().robot_)]; }
  static std::int16_t temperature() { return host().receiving() ? std::int16_t{-1} : host().temperature_[RobotHost::index(host().robot_)]; }
  static std::uint8_t random_byte() { return static_cast<std::uint8_t>(host().hard_random_[RobotHost::index(host().robot_)].next()); }
  static void started() {
    if (host().booting_) FaultGuard::leave(Fault::Kind::left, nullptr);
    FaultGuard::leave(Fault::Kind::gave_up, "called kilo_start() a second time");
  }
  static void ended(const char* why, const void* from) { FaultGuard::leave(Fault::Kind::gave_up, why, from); }
  static void busy_at(const void* from, int wakeable) { host().busy_at(from, wakeable != 0); }
  static void text(const char* text, std::uint32_t size) {
    host().program_->text()->say(host().robot_, host().tick_ * tick_us + (host().booting_ ? 0 : host().cursor_us_), text, size);
  }
};

RobotHost::RobotHost(std::shared_ptr<const RobotProgram> program, int robots, Motors& motors, LedLights& leds, Sensors sensors,
                     const std::string& lab, std::uint64_t seed, double clock_spread, const std::vector<std::uint16_t>& ids)
    : program_(std::move(program)), abi_(program_->abi()), bytes_(program_->memory_bytes()), count_(robots), motors_(motors), leds_(leds),
      sensors_(std::move(sensors)), guard_(FaultGuard::acquire()), clocks_differ_(clock_spread > 0) {
  using Services = RobotServices;
  *abi_.host = {Services::wait_us,  Services::wait_for_tick, Services::motors,      Services::colour, Services::light,  Services::voltage,
                Services::temperature, Services::random_byte, program_->text() ? Services::text : nullptr,
                Services::started, Services::ended, Services::busy_at};
  memory_.resize(bytes_ * index(robots));
  cells_.resize(index(robots));
  hal::RandomStream boot(seed, lab + "/ode/boot"), sensing(seed, lab + "/ode/sensors"), timer_at(seed, lab + "/ode/timer_offset"), clock(seed, lab + "/ode/clock");
  const auto around = [&sensing](int nominal, int spread) {
    return static_cast<std::int16_t>(nominal - spread + static_cast<int>(sensing.below(static_cast<std::uint64_t>(2 * spread + 1))));
  };
  for (int i = 0; i < robots; ++i) {
    uid_.push_back(ids.empty() ? static_cast<std::uint16_t>(i) : ids.at(index(i)));
    loaders_.emplace_back();
    clocks_.push_back({.at_us = static_cast<std::int64_t>(timer_at.below(tick_us)), .late_us = static_cast<std::int64_t>(clock.uniform(-clock_spread, clock_spread) * tick_us)});
    voltage_.push_back(around(nominal_voltage, voltage_spread));
    temperature_.push_back(around(nominal_temperature, temperature_spread));
    hard_random_.emplace_back(seed, lab + "/ode/rand_hard", static_cast<std::uint64_t>(i));
    // switched on by hand, not all in one tick
    boot_phase_.push_back(static_cast<std::uint8_t>(boot.below(16)));
    send_clock_.push_back(0);
  }
  for (int i = 0; i < robots; ++i) {
    power_up(i);
    send_clock_[index(i)] = static_cast<std::uint16_t>(clock_per_tick * boot_phase_[index(i)]);
    const std::uint32_t ticks = boot_phase_[index(i)];
    std::memcpy(memory_.data() + bytes_ * index(i) + offset(abi_, abi_.ticks), &ticks, sizeof ticks);
  }
}

RobotHost::~RobotHost() = default;

void RobotHost::copy_in(int robot) { std::memcpy(abi_.begin, memory_.data() + bytes_ * index(robot), bytes_); }
void RobotHost::copy_out(int robot) { std::memcpy(memory_.data() + bytes_ * index(robot), abi_.begin, bytes_); }

// As after the reset vector: fresh memory, values from the EEPROM, main() up to kilo_start().
void RobotHost::power_up(int robot) {
  std::memcpy(abi_.begin, program_->first_memory().data(), bytes_);
  const Calibration& calibration = motors_.calibration(robot);
  *abi_.uid = uid_[index(robot)];
  *abi_.turn_left = calibration.turn_left;
  *abi_.turn_right = calibration.turn_right;
  *abi_.straight_left = calibration.straight_left;
  *abi_.straight_right = calibration.straight_right;
  std::copy(std::begin(high_table), std::end(high_table), abi_.irhigh);
  std::copy(std::begin(low_table), std::end(low_table), abi_.irlow);

  cells_[index(robot)] = {};
  send_clock_[index(robot)] = 0;
  motors_.connect(robot, false, 0);
  motors_.set(robot, 0, 0, 0);
  leds_.set(robot, 0, 0);
  robot_ = robot;
  cursor_us_ = 0;
  booting_ = true;
  running = this;
  const Fault fault = guard_->run(
      [](void* host) {
        FaultGuard::enter_program();
        static_cast<RobotHost*>(host)->abi_.main();
        FaultGuard::leave_program();
      },
      this);
  booting_ = false;
  if (fault.kind != Fault::Kind::none && fault.kind != Fault::Kind::left) report(fault);
  if (!*abi_.loop || !*abi_.setup) throw ProgramFault(fmt::format("the program of robot {} never calls kilo_start(setup, loop)", robot));
  copy_out(robot);
}

void RobotHost::set_power(int robot, bool on) {
  if (powered(robot) == on) return;
  if (on) {
    loaders_[index(robot)] = {};
    return power_up(robot);
  }
  forget_program(cells_[index(robot)]);
  cells_[index(robot)] = {.state = State::off, .shown = State::off};
  motors_.connect(robot, false, 0);
  motors_.set(robot, 0, 0, 0);
  leds_.set(robot, 0, 0);
}

// Whatever its program was doing.
void RobotHost::forget_program(Cell& cell) {
  if (!cell.context) return;
  stacks_.give(cell.stack);
  --waiting_;
  cell.context = nullptr;
}

void RobotHost::report(const Fault& fault) {
  const std::string place = fault.instruction ? program_->place_of(fault.instruction) : std::string{};
  std::string what;
  switch (fault.kind) {
    case Fault::Kind::gave_up: what = fault.words; break;
    case Fault::Kind::hang:
      what = fault.instruction && place.empty() ? "never returns: it calls the library for ever without letting time pass" : "never returns";
      break;
    default:
      if (fault.signal == SIGFPE) what = "crashed: division by zero";
      else if (stacks_.is_fence(fault.address)) what = "crashed: stack overflow";
      else if (fault.signal == SIGSEGV || fault.signal == SIGBUS) what = "crashed: bad pointer";
      else what = fmt::format("crashed: signal {}", fault.signal);
  }
  const double at_s = static_cast<double>(tick_ * tick_us + (booting_ ? 0 : cursor_us_)) * 1e-6;
  throw ProgramFault(fmt::format("the program of robot {} {}{} at {:.3f} s ({})", robot_, what, place, at_s, program_->source().string()));
}

// ---- the walk ----

void RobotHost::tick(std::int64_t number, const Inbox& inbox) {
  tick_ = number;
  inbox_ = &inbox;
  due_.clear();
  resets_.clear();
  robot_ = 0;
  phase_ = Phase::enter;
  next_infrared_ = 0;
  running = this;

  const Fault fault = guard_->run(
      [](void* self) {
        RobotHost& host = *static_cast<RobotHost*>(self);
        if (!host.worker_) host.worker_ = host.new_worker();
        host.save_to_ = &host.scheduler_;
        host.worker_ = switch_to(host.worker_, host.stack_->bounds(), self);
      },
      this);
  if (fault.kind != Fault::Kind::none) {
    leaving_for(scheduler_stack_);
    arrived();
    report(fault);
  }
  for (int robot : resets_) power_up(robot);
}

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
          if (cell.state == State::running && cell.has_setup && !cell.context) run_program();
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
        const Cell& cell = cells_[i];
        if (cell.shown != cell.state && !cell.context) show_state();
        send_clock_[i] = static_cast<std::uint16_t>(send_clock_[i] + clock_per_tick * beats_);
        const bool talks = *abi_.tx && *abi_.tx != abi_.no_tx;
        if (beats_ > 0 && send_clock_[i] > *abi_.tx_period && cell.state == State::running && talks) due_.push_back(robot_);
        copy_out(robot_);
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
      if (heard.message.type > 127 && (repeats_ || heard.missed.empty() || !heard.missed[index(robot_)])) cell.heard_asleep = heard.message.type;
    if (cell.heard_asleep == 0 || (tick_ - cell.slept_at) % sleep_ticks != 0) return false;
    copy_in(robot_);
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
  copy_in(robot_);
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

// The program has computed for a tick: it gets the rest of its time in the next one. It hangs when it has done nothing else for long and
// nothing can interrupt it: it has no callbacks, or runs in one.
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
    FaultGuard::leave(Fault::Kind::gave_up, "waits in delay(), but the system has no memory for one more waiting program");
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

// ---- commands of the overhead controller ----

void RobotHost::take_command(const Message& message) {
  Cell& cell = cells_[index(robot_)];
  if (cell.state == State::loader) {
    cell.reset = loaders_[index(robot_)].hear(message);
    leds_.set(robot_, loaders_[index(robot_)].colour(), cursor_us_);
    if (!cell.reset) return;
  }
  if (message.type != type_run && message.type != type_read_uid && message.type != type_calibrate) motors_.connect(robot_, false, cursor_us_);
  switch (message.type) {
    case type_boot:
      if (cell.reset) break;
      loaders_[index(robot_)].start();
      change_state(State::loader);
      break;
    case type_reset: cell.reset = true; break;
    case type_sleep: change_state(State::sleeping); break;
    case type_wakeup: change_state(State::idle); break;
    case type_charge: change_state(State::charging); break;
    case type_voltage: change_state(State::battery); break;
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
    default: break;
  }
  if (cell.state == State::moving) {
    motors_.connect(robot_, true, cursor_us_);
    const std::uint8_t left = cell.motion == 1 ? *abi_.turn_left : cell.motion == 3 ? *abi_.straight_left : std::uint8_t{0};
    const std::uint8_t right = cell.motion == 2 ? *abi_.turn_right : cell.motion == 3 ? *abi_.straight_right : std::uint8_t{0};
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

// ---- sending ----

std::optional<Message> RobotHost::ask(int robot, bool channel_is_free) {
  asked_.reset();
  if (!powered(robot)) return asked_;
  channel_is_free_ = channel_is_free;
  robot_ = robot;
  running = this;
  copy_in(robot);
  const Fault fault = guard_->run(
      [](void* self) {
        RobotHost& host = *static_cast<RobotHost*>(self);
        host.in_callback_ = true;
        host.callback_busy_ = 0;
        FaultGuard::enter_program();
        const void* const message = (*host.abi_.tx)();
        if (message) {
          std::memcpy(&host.asked_.emplace(), message, sizeof(Message));
          if (host.channel_is_free_ && *host.abi_.tx_success) (*host.abi_.tx_success)();
        }
        FaultGuard::leave_program();
        host.in_callback_ = false;
      },
      this);
  if (fault.kind != Fault::Kind::none) report(fault);
  copy_out(robot);
  if (asked_ && channel_is_free) send_clock_[index(robot)] = 0;
  return asked_;
}

std::uint32_t RobotHost::back_off(int robot) {
  copy_in(robot);
  *abi_.ticks = *abi_.ticks + 1;
  const auto counts = static_cast<std::uint32_t>(abi_.rand() & 0xFF);
  copy_out(robot);
  return counts * 128;
}

void RobotHost::set_readings(int, double distance_m, Reception& reception) const {
  // the straight lines of the calibration tables, read backwards; a little above, because estimates are truncated
  const double gap_mm = std::max(0.0, (distance_m - 2 * hal::kilobot_radius_m) * 1000 + 0.02);
  const auto reading = [gap_mm](const std::uint16_t* table) {
    const int k = std::clamp(static_cast<int>(gap_mm / 5), 0, 12);
    const double slope = (table[k + 1] - table[k]) / 5.0;
    return static_cast<std::int16_t>(std::clamp(table[k] + slope * (gap_mm - 5 * k), 0.0, 1023.0) + 0.5);
  };
  reception.high_gain = reading(high_table);
  reception.low_gain = reading(low_table);
}

std::uint32_t RobotHost::ticks(int robot) const {
  std::uint32_t value;
  std::memcpy(&value, memory_.data() + bytes_ * index(robot) + offset(abi_, abi_.ticks), sizeof value);
  return value;
}

}  // namespace arkmesh::sim_ode
