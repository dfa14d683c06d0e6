#include "sim_ode/host/robot_host.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <csignal>
#include <utility>

#include "hal/counted.hpp"
#include "sim_ode/host/turns/eeprom.hpp"

namespace arkmesh::sim_ode {
namespace {

// Lab time without anything to be seen of a program that waits, after which it is told, and how often that is looked
// for.
constexpr std::int64_t idle_told_us = 5'000'000, idle_check_ticks = 16;
constexpr std::int64_t idle_run_us = 10'000'000;  // a shorter run says nothing of robots that did nothing

std::vector<RobotClock> make_clocks(const std::vector<RobotProfile>& profiles, const std::string& lab,
                                    std::uint64_t seed, int first, int robots) {
  hal::RandomStream timer_at(seed, lab + "/ode/timer_offset");
  std::vector<RobotClock> out;
  for (const RobotProfile& robot : profiles)
    out.push_back({.at_us = static_cast<std::int64_t>(timer_at.below(tick_us)),
                   .late_us = static_cast<std::int64_t>(robot.clock_slow * tick_us)});
  return {out.begin() + first, out.begin() + first + robots};
}

std::vector<SendTimer> make_timers(const std::vector<RobotProfile>& profiles, const std::string& lab,
                                   std::uint64_t seed, int first, int robots) {
  std::vector<SendTimer> out;
  for (const RobotProfile& robot : profiles)
    out.emplace_back(robot.send_spread, hal::RandomStream(seed, lab + "/ode/send_timer", out.size()));
  return {out.begin() + first, out.begin() + first + robots};
}

std::vector<std::string> numbers(int robots) {
  std::vector<std::string> out;
  for (int i = 0; i < robots; ++i) out.push_back(std::to_string(i));
  return out;
}

bool clocks_differ(const std::vector<RobotProfile>& profiles) {
  return std::ranges::any_of(profiles, [](const RobotProfile& robot) { return robot.clock_slow != 0; });
}

}  // namespace

RobotHost::RobotHost(std::shared_ptr<const RobotProgram> program, int robots, Motors& motors, LedLights& leds,
                     RobotSensors sensors, const std::string& lab, std::uint64_t seed,
                     const std::vector<std::uint16_t>& ids, const RobotOutput& output, int first)
    : program_(std::move(program)),
      guard_(FaultGuard::acquire()),
      bodies_(robots, motors, leds, std::move(sensors), lab, seed, ids, first),
      heaps_(program_->heap_bytes(), robots),
      files_(output.folder, output.names.empty() ? numbers(robots) : output.names),
      memory_(program_->abi().begin, program_->first_memory(), robots),
      turns_(program_->abi(), memory_, heaps_, files_, bodies_, *guard_,
             make_clocks(motors.profiles(), lab, seed, first, robots),
             make_timers(motors.profiles(), lab, seed, first, robots), clocks_differ(motors.profiles()), output.text,
             output.log),
      robots_(robots) {
  hal::RandomStream boot(seed, lab + "/ode/boot");
  const FaultGuard::Watch watch(*guard_);
  for (int i = -first; i < robots; ++i) {
    // switched on by hand, not all in one tick
    const auto ticks_on = static_cast<std::uint32_t>(boot.below(16));
    if (i < 0) continue;
    turns_.write_eeprom(i);
    power_up(i);
    turns_.firmware(i).count(ticks_on);
    memory_.write(i, program_->abi().ticks, ticks_on);
  }
}

void RobotHost::power_up(int robot) {
  Fault fault = turns_.boot(robot);
  // on a robot it would do so for ever, whatever it is told
  if (fault.kind == Fault::Kind::hang)
    fault = {.kind = Fault::Kind::gave_up,
             .instruction = fault.instruction,
             .words = "never calls kilo_start(setup, loop); move to loop() what it repeats"};
  if (fault.kind != Fault::Kind::none && fault.kind != Fault::Kind::left) report(fault);
  if (!*program_->abi().loop || !*program_->abi().setup)
    throw ProgramFault(
        fmt::format("the program of robot {} never calls kilo_start(setup, loop)", bodies_.number(robot)));
}

std::uint16_t RobotHost::id_of(int robot) const {
  const std::uint8_t* const eeprom = program_->abi().eeprom;
  if (!eeprom) return bodies_.values(robot).uid;
  const auto byte = [this, robot, eeprom](std::size_t at) { return 0xFF & ~memory_.read(robot, eeprom + at); };
  return static_cast<std::uint16_t>(byte(eeprom_uid) | byte(eeprom_uid + 1) << 8);
}

void RobotHost::set_power(int robot, bool on) {
  if (powered(robot) == on) return;
  if (!on) return turns_.switch_off(robot);
  turns_.loader(robot) = {};
  power_up(robot);
}

void RobotHost::tick(std::int64_t number, const Inbox& inbox) {
  for (Fault fault = turns_.walk(number, inbox); fault.kind != Fault::Kind::none;
       fault = turns_.walk_on_without_robot())
    leave_or_report(fault);
  for (int robot : turns_.resets()) power_up(robot);
  if (heaps_.in_use()) tell_of_heap_misuse();
  if (number % idle_check_ticks == 0) tell_of_idle_waits();
}

// No fault: a callback, or the time, may still end the wait.
void RobotHost::tell_of_idle_waits() {
  constexpr int most_told = 10;
  std::vector<Turns::Wait> waits = turns_.idle_waits(idle_told_us);
  std::erase_if(waits, [this](const Turns::Wait& wait) {
    return bodies_.moves(wait.robot) || !waited_.insert(wait.robot).second;
  });
  if (waits.empty() || ++told_of_idle_ > most_told) return;
  const Turns::Wait& first = waits.front();
  const std::string others = waits.size() == 1 ? "" : ", and so do " + hal::counted(waits.size() - 1, "more robot");
  spdlog::warn(
      "the program of robot {} has not returned from loop, and set neither motors nor LED, since {:.3f} s: it waits{} "
      "({}){}",
      bodies_.number(first.robot), static_cast<double>(first.since_us) * 1e-6,
      first.from ? program_->place_of(first.from) : "", program_->source().string(), others);
}

void RobotHost::tell_at_end() const {
  const std::size_t idle = turns_.idle_robots();
  const std::int64_t lasted_us = turns_.tick() * tick_us;
  const std::string source = program_->source().string();
  if (idle > 0 && lasted_us >= idle_run_us)
    spdlog::warn(
        "{} of {}, ids {} to {}, neither drove, nor sent, nor changed the LED after setup in {:.0f} s; usual causes: "
        "the program counts calls of loop (loops_per_tick), waits for a message that never came, or is for other ids "
        "(ids) ({})",
        idle, hal::counted(robots_, "robot"), id_of(0), id_of(robots_ - 1), static_cast<double>(lasted_us) * 1e-6,
        source);
  if (turns_.measures_overhead() && overhead_is_assumed_)
    spdlog::warn(
        "the program asks for the distance of the overhead controller: {:.0f} mm by assumption, in ARGoS 0; "
        "arena.ode.overhead_distance_m sets it ({})",
        assumed_overhead_m * 1000, source);
}

// No fault: on a robot nothing would be seen, and it is the robot's own memory. Each place is told once.
void RobotHost::tell_of_heap_misuse() {
  constexpr std::size_t most_places = 10;
  for (const RobotHeaps::Misuse& misuse : heaps_.take_misuse()) {
    ++heap_misuse_;
    const void* const noticed = misuse.noticed ? misuse.noticed : reinterpret_cast<const void*>(*program_->abi().loop);
    if (told_places_.size() == most_places || !told_places_.insert(misuse.bytes ? misuse.from : noticed).second)
      continue;
    const std::string what = misuse.bytes == 0
                                 ? "frees memory that malloc() did not return, or that it freed before,"
                                 : fmt::format("has written beyond the {} that it allocated{}: noticed",
                                               hal::counted(misuse.bytes, "byte"), program_->place_of(misuse.from));
    spdlog::warn("the program of robot {} {}{} at {:.3f} s; only its own memory is damaged ({})",
                 bodies_.number(misuse.robot), what, program_->place_of(noticed),
                 static_cast<double>(turns_.tick() * tick_us) * 1e-6, program_->source().string());
  }
}

Reply RobotHost::send_turn(const Outcome& outcome) {
  Reply reply;
  const Fault fault = turns_.send(outcome, reply);
  if (fault.kind == Fault::Kind::none) return reply;
  leave_or_report(fault);
  turns_.give_up_robot();
  return {};
}

// `place` is the source line where it happened, perhaps empty.
std::string RobotHost::words_for(const Fault& fault, const std::string& place) const {
  switch (fault.kind) {
    case Fault::Kind::gave_up:
      return fault.words;
    case Fault::Kind::hang:
      return fault.instruction && place.empty()
                 ? "never returns: it calls the library forever without letting time pass"
                 : "never returns";
    default:
      if (fault.signal == SIGFPE) return "crashed: division by zero";
      if (turns_.is_below_stack(fault.address)) return "crashed: stack overflow";
      if (turns_.is_above_stack(fault.address)) return "crashed: bad index or pointer, beyond its stack";
      if (fault.astray && place.empty()) return "crashed: it damaged its stack";
      if (fault.signal == SIGSEGV || fault.signal == SIGBUS) return "crashed: bad pointer";
      // it has said why on the standard error stream
      if (fault.signal == SIGABRT) return "crashed: the C library ended it";
      return fmt::format("crashed: signal {}", fault.signal);
  }
}

std::string RobotHost::sentence_for(const Fault& fault) const {
  const std::string place = fault.instruction ? program_->place_of(fault.instruction) : std::string{};
  return fmt::format("the program of robot {} {}{} at {:.3f} s ({})", bodies_.number(turns_.robot()),
                     words_for(fault, place),
                     fault.astray && place.empty() ? program_->place_of(turns_.called()) : place,
                     static_cast<double>(turns_.now_us()) * 1e-6, program_->source().string());
}

void RobotHost::report(const Fault& fault) const {
  throw ProgramFault(sentence_for(fault));
}

void RobotHost::leave_or_report(const Fault& fault) {
  if (!leave_failed_) report(fault);
  spdlog::warn("{}; it stands still from now on", sentence_for(fault));
  ++failed_robots_;
}

}  // namespace arkmesh::sim_ode
