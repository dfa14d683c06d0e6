#include "sim_ode/host/turns/robot_services.hpp"

#include "hal/fixed_math.hpp"
#include "sim_ode/host/turns/turns.hpp"

namespace arkmesh::sim_ode {

arkmesh_host RobotServices::all(bool prints) {
  return {.wait_us = wait_us,
          .wait_for_tick = wait_for_tick,
          .motors = motors,
          .colour = colour,
          .light = light,
          .voltage = voltage,
          .temperature = temperature,
          .random_byte = random_byte,
          .text = prints ? text : nullptr,
          .started = started,
          .ended = ended,
          .busy_at = busy_at,
          .jumps = jumps,
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
void RobotServices::wait_us(std::uint32_t us, const void* from) {
  turns().wait(us + us * turns().clocks_[Turns::index(turns().robot_)].late_us / tick_us, from);
}
void RobotServices::wait_for_tick(const void* from) {
  turns().wait_for_tick(from);
}
void RobotServices::motors(std::uint8_t left, std::uint8_t right) {
  if (left > 0 || right > 0 || turns().bodies_.moves(turns().robot_)) turns().acts();
  turns().bodies_.drive(turns().robot_, left, right, turns().cursor_us_);
}
void RobotServices::colour(std::uint8_t colour) {
  if (turns().bodies_.colour(turns().robot_) != colour) turns().acts();
  turns().bodies_.show(turns().robot_, colour, turns().cursor_us_);
}
std::int16_t RobotServices::light() {
  return receives() ? std::int16_t{-1} : turns().bodies_.light(turns().robot_);
}
std::int16_t RobotServices::voltage() {
  return receives() ? std::int16_t{-1} : turns().bodies_.voltage(turns().robot_);
}
std::int16_t RobotServices::temperature() {
  return receives() ? std::int16_t{-1} : turns().bodies_.temperature(turns().robot_);
}
std::uint8_t RobotServices::random_byte() {
  return turns().bodies_.random_byte(turns().robot_);
}
void RobotServices::started() {
  if (turns().booting_) FaultGuard::leave(Fault::Kind::left, nullptr);
  FaultGuard::leave(Fault::Kind::gave_up, "called kilo_start() a second time");
}
void RobotServices::ended(const char* why, const void* from) {
  FaultGuard::leave(Fault::Kind::gave_up, why, from);
}
void RobotServices::busy_at(const void* from, int wakeable) {
  turns().busy_at(from, wakeable != 0);
}
void RobotServices::jumps(const void* from) {
  if (turns().in_callback_) FaultGuard::leave(Fault::Kind::gave_up, "called longjmp() in a callback", from);
}
void RobotServices::text(const char* text, std::uint32_t size) {
  turns().text_->say(turns().robot_, turns().now_us(), text, size);
}

}  // namespace arkmesh::sim_ode
