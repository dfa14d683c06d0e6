// A robot's life between its turns: powering up, being asked for messages, failing. The turns are in robot_walk.cpp,
// what commands do in robot_commands.cpp.
#include "sim_ode/host/robot_host.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <utility>

#include "sim_ode/host/distance_readings.hpp"
#include "sim_ode/host/robot_services.hpp"

namespace arkmesh::sim_ode {
namespace {

// Battery and temperature: Kilombo's values, and how far a robot's may lie off them (our assumption).
constexpr int nominal_voltage = 876, voltage_spread = 30, nominal_temperature = 314, temperature_spread = 4;

constexpr std::uint32_t timer_count_us = 128;  // of the robot's timer

}  // namespace

RobotHost* RobotHost::running_ = nullptr;

RobotHost::RobotHost(std::shared_ptr<const RobotProgram> program, int robots, Motors& motors, LedLights& leds,
                     Sensors sensors, const std::string& lab, std::uint64_t seed, double clock_spread,
                     const std::vector<std::uint16_t>& ids)
    : program_(std::move(program)),
      abi_(program_->abi()),
      count_(robots),
      motors_(motors),
      leds_(leds),
      sensors_(std::move(sensors)),
      guard_(FaultGuard::acquire()),
      memory_(abi_.begin, program_->memory_bytes(), robots),
      clocks_differ_(clock_spread > 0) {
  *abi_.host = RobotServices::all(program_->text() != nullptr);
  cells_.resize(index(robots));
  hal::RandomStream boot(seed, lab + "/ode/boot"), sensing(seed, lab + "/ode/sensors"),
      timer_at(seed, lab + "/ode/timer_offset"), clock(seed, lab + "/ode/clock");
  const auto around = [&sensing](int nominal, int spread) {
    return static_cast<std::int16_t>(nominal - spread +
                                     static_cast<int>(sensing.below(static_cast<std::uint64_t>(2 * spread + 1))));
  };
  for (int i = 0; i < robots; ++i) {
    uid_.push_back(ids.empty() ? static_cast<std::uint16_t>(i) : ids.at(index(i)));
    loaders_.emplace_back();
    clocks_.push_back({.at_us = static_cast<std::int64_t>(timer_at.below(tick_us)),
                       .late_us = static_cast<std::int64_t>(clock.uniform(-clock_spread, clock_spread) * tick_us)});
    voltage_.push_back(around(nominal_voltage, voltage_spread));
    temperature_.push_back(around(nominal_temperature, temperature_spread));
    hard_random_.emplace_back(seed, lab + "/ode/rand_hard", static_cast<std::uint64_t>(i));
    // switched on by hand, not all in one tick
    boot_phase_.push_back(static_cast<std::uint8_t>(boot.below(16)));
  }
  const FaultGuard::Watch watch(*guard_);
  for (int i = 0; i < robots; ++i) {
    power_up(i);
    cells_[index(i)].send_clock = static_cast<std::uint16_t>(clock_per_tick * boot_phase_[index(i)]);
    memory_.write(i, abi_.ticks, static_cast<std::uint32_t>(boot_phase_[index(i)]));
  }
}

RobotHost::~RobotHost() = default;

// As after the reset vector: fresh memory, values from the EEPROM, main() up to kilo_start().
void RobotHost::power_up(int robot) {
  std::memcpy(abi_.begin, program_->first_memory().data(), program_->memory_bytes());
  const Calibration& calibration = motors_.calibration(robot);
  *abi_.uid = uid_[index(robot)];
  *abi_.turn_left = calibration.turn_left;
  *abi_.turn_right = calibration.turn_right;
  *abi_.straight_left = calibration.straight_left;
  *abi_.straight_right = calibration.straight_right;
  std::copy(high_gain_table.begin(), high_gain_table.end(), abi_.irhigh);
  std::copy(low_gain_table.begin(), low_gain_table.end(), abi_.irlow);

  cells_[index(robot)] = {};
  motors_.connect(robot, false, 0);
  motors_.set(robot, 0, 0, 0);
  leds_.put_out(robot);
  robot_ = robot;
  cursor_us_ = 0;
  booting_ = true;
  running_ = this;
  const Fault fault = guard_->run(
      [](void* host) {
        FaultGuard::enter_program();
        static_cast<RobotHost*>(host)->abi_.main();
        FaultGuard::leave_program();
      },
      this);
  booting_ = false;
  if (fault.kind != Fault::Kind::none && fault.kind != Fault::Kind::left) report(fault);
  if (!*abi_.loop || !*abi_.setup)
    throw ProgramFault(fmt::format("the program of robot {} never calls kilo_start(setup, loop)", robot));
  memory_.copy_out(robot);
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
  leds_.put_out(robot);
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
    case Fault::Kind::gave_up:
      what = fault.words;
      break;
    case Fault::Kind::hang:
      what = fault.instruction && place.empty()
                 ? "never returns: it calls the library for ever without letting time pass"
                 : "never returns";
      break;
    default:
      if (fault.signal == SIGFPE)
        what = "crashed: division by zero";
      else if (stacks_.is_fence(fault.address))
        what = "crashed: stack overflow";
      else if (fault.signal == SIGSEGV || fault.signal == SIGBUS)
        what = "crashed: bad pointer";
      else if (fault.signal == SIGABRT)
        what = "crashed: the C library ended it";  // and said why on the standard error stream
      else
        what = fmt::format("crashed: signal {}", fault.signal);
  }
  const double at_s = static_cast<double>(tick_ * tick_us + (booting_ ? 0 : cursor_us_)) * 1e-6;
  throw ProgramFault(fmt::format("the program of robot {} {}{} at {:.3f} s ({})", robot_, what, place, at_s,
                                 program_->source().string()));
}

void RobotHost::tick(std::int64_t number, const Inbox& inbox) {
  tick_ = number;
  inbox_ = &inbox;
  offers_.clear();
  resets_.clear();
  robot_ = 0;
  phase_ = Phase::enter;
  next_infrared_ = 0;
  running_ = this;

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

Reply RobotHost::send_turn(const Outcome& outcome) {
  const int robot = outcome.robot;
  reply_ = {};
  if (!cells_[index(robot)].runs()) return reply_;  // no longer, since it backed off
  outcome_ = outcome;
  robot_ = robot;
  running_ = this;
  memory_.copy_in(robot);
  const Fault fault = guard_->run(
      [](void* self) {
        RobotHost& host = *static_cast<RobotHost*>(self);
        host.in_callback_ = true;
        host.callback_busy_ = 0;
        FaultGuard::enter_program();
        const void* const message = (*host.abi_.tx)();
        if (message) {
          std::memcpy(&host.reply_.message.emplace(), message, sizeof(Message));
          if (!host.outcome_.free) host.reply_.back_off_us = host.abi_.back_off() * timer_count_us;
          if (host.outcome_.free && *host.abi_.tx_success) (*host.abi_.tx_success)();
        }
        FaultGuard::leave_program();
        host.in_callback_ = false;
      },
      this);
  if (fault.kind != Fault::Kind::none) report(fault);
  if (reply_.message && outcome.free) cells_[index(robot)].send_clock = 0;
  memory_.copy_out(robot);
  return reply_;
}

std::uint32_t RobotHost::ticks(int robot) const {
  return memory_.read(robot, abi_.ticks);
}

}  // namespace arkmesh::sim_ode
