#include "sim_ode/host/turns/robot_services.hpp"

#include <algorithm>
#include <cstdio>

#include "hal/fixed_math.hpp"
#include "sim_ode/host/turns/turns.hpp"

namespace arkmesh::sim_ode {

arkmesh_host RobotServices::all() {
  return {.wait_us = wait_us,
          .wait_for_tick = wait_for_tick,
          .motors = motors,
          .colour = colour,
          .light = light,
          .voltage = voltage,
          .temperature = temperature,
          .random_byte = random_byte,
          .text = text,
          .started = started,
          .ended = ended,
          .busy_at = busy_at,
          .jumps = jumps,
          .reallocate = reallocate,
          .open = open,
          .close = close,
          .write = write,
          .print = print,
          .format = std::vsnprintf,
          .scan = std::vsscanf,
          .scan_file = std::vfscanf,
          .say = say,
          .prox = prox,
#define MATHEMATICS(name) .name = hal::fixed::name,
          ARKMESH_MATHEMATICS(MATHEMATICS, MATHEMATICS)
#undef MATHEMATICS
  };
}

Turns& RobotServices::turns() {
  return *Turns::running_;
}
// Robots are still alone while main() runs.
bool RobotServices::receives() {
  return !turns().booting_ && turns().bodies_.receives(turns().robot_, turns().now_us());
}
// A reading, which the log keeps.
template <class Reading>
Reading RobotServices::noted(char letter, Reading reading) {
  turns().note(letter, reading);
  return reading;
}
void RobotServices::wait_us(std::uint32_t us, const void* from) {
  const bool prints = !from;  // on the serial line, with no call of the library
  if (prints)
    turns().note('w', std::uint8_t{1});
  else
    turns().note('d', us);
  if (turns().log_) turns().log_memory();
  turns().wait(us + us * turns().clocks_[Turns::index(turns().robot_)].late_us / tick_us, from);
  turns().note(prints ? 'W' : 'D');
}
void RobotServices::wait_for_tick(const void* from) {
  turns().note('w', std::uint8_t{0});
  if (turns().log_) turns().log_memory();
  turns().wait_for_tick(from);
  turns().note('W');
}
void RobotServices::motors(std::uint8_t left, std::uint8_t right) {
  turns().note('m', left, right);
  const bool drives = left > 0 || right > 0;
  if (drives || turns().bodies_.moves(turns().robot_)) turns().acts(drives);
  turns().bodies_.drive(turns().robot_, left, right, turns().cursor_us_);
}
void RobotServices::colour(std::uint8_t colour) {
  turns().note('c', colour);
  const std::uint8_t before = turns().bodies_.colour(turns().robot_);
  if (before != colour) turns().acts(before > 0 || turns().has_setup());
  turns().bodies_.show(turns().robot_, colour, turns().cursor_us_);
}
std::int16_t RobotServices::light() {
  return noted('l', receives() ? std::int16_t{-1} : turns().bodies_.light(turns().robot_));
}
std::int16_t RobotServices::voltage() {
  return noted('o', receives() ? std::int16_t{-1} : turns().bodies_.voltage(turns().robot_));
}
std::int16_t RobotServices::temperature() {
  return noted('e', receives() ? std::int16_t{-1} : turns().bodies_.temperature(turns().robot_));
}
std::uint8_t RobotServices::random_byte() {
  return noted('h', turns().bodies_.random_byte(turns().robot_));
}
void RobotServices::started() {
  turns().note('s');
  if (turns().log_) turns().log_memory();
  if (turns().booting_) FaultGuard::leave(Fault::Kind::left, nullptr);
  FaultGuard::leave(Fault::Kind::gave_up, "called kilo_start() a second time");
}
void RobotServices::ended(const char* why, const void* from) {
  FaultGuard::leave(Fault::Kind::gave_up, why, from);
}
void RobotServices::busy_at(const void* from, int wakeable) {
  turns().note('w', std::uint8_t{1});
  if (turns().log_) turns().log_memory();
  turns().busy_at(from, wakeable != 0);
  turns().note('W');
}
void RobotServices::jumps(const void* from) {
  if (turns().in_callback_) FaultGuard::leave(Fault::Kind::gave_up, "called longjmp() in a callback", from);
}

// What allocates for the simulator is not to be left by a jump.
template <class Work>
auto RobotServices::undisturbed(Work work) {
  FaultGuard::leave_program();
  const auto done = work();
  FaultGuard::enter_program();
  return done;
}
void* RobotServices::reallocate(void* old, std::size_t size, const void* from) {
  return undisturbed([&] {
    turns().memory_.use(turns().heaps_);
    return turns().heaps_.reallocate(turns().robot_, old, size, from);
  });
}
FILE* RobotServices::open(const char* name, const char* mode) {
  return undisturbed([&] { return turns().files_.open(turns().robot_, name, mode); });
}
int RobotServices::close(FILE* stream) {
  return undisturbed([&] { return turns().files_.has(stream) ? turns().files_.close(stream) : -1; });
}
int RobotServices::write(FILE* stream, const void* data, std::size_t size) {
  if (!turns().files_.has(stream)) return -1;
  return undisturbed([&] {
    if (size > 0) std::fwrite(data, 1, size, stream);
    return std::fflush(stream);
  });
}
int RobotServices::print(FILE* stream, const char* format, va_list values) {
  if (!turns().files_.has(stream)) return -1;
  return undisturbed([&] { return std::max(0, std::vfprintf(stream, format, values)); });
}
void RobotServices::text(const char* text, std::uint32_t size) {
  if (turns().text_) return turns().text_->say(turns().bodies_.number(turns().robot_), turns().now_us(), text, size);
  undisturbed([&] {
    turns().files_.print(turns().robot_, {text, size});
    return 0;
  });
}
void RobotServices::say(std::uint8_t kind, std::int32_t value, const void* from) {
  turns().note('y', kind, value);
  turns().acts(true);
  if (!turns().bodies_.say(turns().robot_, kind, value))
    FaultGuard::leave(Fault::Kind::gave_up, "called arkmesh_say(), but no overhead controller hears robots", from);
}
std::int16_t RobotServices::prox(std::uint8_t sensor, const void* from) {
  if (const auto reading = turns().bodies_.prox(turns().robot_, sensor)) return *reading;
  FaultGuard::leave(Fault::Kind::gave_up, "asked for a proximity sensor that its robot does not have", from);
}

}  // namespace arkmesh::sim_ode
