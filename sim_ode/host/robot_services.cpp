#include "sim_ode/host/robot_services.hpp"

#include "sim_ode/host/robot_host.hpp"

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
          .jumps = jumps};
}

RobotHost& RobotServices::host() {
  return *RobotHost::running_;
}
void RobotServices::wait_us(std::uint32_t us) {
  host().wait(us + us * host().clocks_[RobotHost::index(host().robot_)].late_us / tick_us);
}
void RobotServices::wait_for_tick(const void* from) {
  host().wait_for_tick(from);
}
void RobotServices::motors(std::uint8_t left, std::uint8_t right) {
  host().motors_.set(host().robot_, left, right, host().cursor_us_);
}
void RobotServices::colour(std::uint8_t colour) {
  host().leds_.set(host().robot_, colour, host().cursor_us_);
}
std::int16_t RobotServices::light() {
  if (host().receiving()) return -1;
  return host().sensors_.light ? host().sensors_.light(host().robot_) : std::int16_t{0};
}
std::int16_t RobotServices::voltage() {
  return host().receiving() ? std::int16_t{-1} : host().voltage_[RobotHost::index(host().robot_)];
}
std::int16_t RobotServices::temperature() {
  return host().receiving() ? std::int16_t{-1} : host().temperature_[RobotHost::index(host().robot_)];
}
std::uint8_t RobotServices::random_byte() {
  return static_cast<std::uint8_t>(host().hard_random_[RobotHost::index(host().robot_)].next());
}
void RobotServices::started() {
  if (host().booting_) FaultGuard::leave(Fault::Kind::left, nullptr);
  FaultGuard::leave(Fault::Kind::gave_up, "called kilo_start() a second time");
}
void RobotServices::ended(const char* why, const void* from) {
  FaultGuard::leave(Fault::Kind::gave_up, why, from);
}
void RobotServices::busy_at(const void* from, int wakeable) {
  host().busy_at(from, wakeable != 0);
}
void RobotServices::jumps(const void* from) {
  if (host().in_callback_) FaultGuard::leave(Fault::Kind::gave_up, "called longjmp() in a callback", from);
}
void RobotServices::text(const char* text, std::uint32_t size) {
  host().program_->text()->say(host().robot_, host().tick_ * tick_us + (host().booting_ ? 0 : host().cursor_us_), text,
                               size);
}

}  // namespace arkmesh::sim_ode
