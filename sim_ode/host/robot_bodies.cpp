#include "sim_ode/host/robot_bodies.hpp"

#include <cmath>

namespace arkmesh::sim_ode {
namespace {

// Battery and temperature: Kilombo's values, and how far a robot's may lie off them (our assumption).
constexpr int nominal_voltage = 876, voltage_spread = 30, nominal_temperature = 314, temperature_spread = 4;
// Of a full battery that runs down, 4.2 V: the firmware's command VOLTAGE tells batteries apart at 682, 648 and 614,
// which at 1024 for 6 V are 4.0, 3.8 and 3.6 V.
constexpr double full_voltage = 716;

}  // namespace

RobotBodies::RobotBodies(int robots, Motors& motors, LedLights& leds, RobotSensors sensors, const std::string& lab,
                         std::uint64_t seed, const std::vector<std::uint16_t>& ids, int first)
    : first_(first), motors_(motors), leds_(leds), sensors_(std::move(sensors)) {
  hal::RandomStream sensing(seed, lab + "/ode/sensors");
  const auto around = [&sensing](int nominal, int spread) {
    return static_cast<std::int16_t>(nominal - spread +
                                     static_cast<int>(sensing.below(static_cast<std::uint64_t>(2 * spread + 1))));
  };
  for (int i = 0; i < first + robots; ++i) {
    const std::int16_t voltage = around(nominal_voltage, voltage_spread),
                       temperature = around(nominal_temperature, temperature_spread);
    if (i < first) continue;  // as they are drawn whatever group they are in
    uid_.push_back(ids.empty() ? static_cast<std::uint16_t>(i) : ids.at(index(i)));
    voltage_.push_back(voltage);
    temperature_.push_back(temperature);
    hard_random_.emplace_back(seed, lab + "/ode/rand_hard", static_cast<std::uint64_t>(i));
  }
}

std::int16_t RobotBodies::voltage(int robot) const {
  const std::int16_t drawn = voltage_[index(robot)];
  if (!sensors_.voltage) return drawn;
  return static_cast<std::int16_t>(drawn - nominal_voltage +
                                   std::lround(full_voltage * sensors_.voltage(number(robot))));
}

void RobotBodies::apply(int robot, const Effects& effects, const RobotValues& values, std::int64_t us) {
  if (effects.outputs != Effects::Outputs::keep) {
    motors_.set(number(robot), 0, 0, us);
    motors_.connect(number(robot), effects.outputs == Effects::Outputs::connect, us);
  }
  if (effects.colour) leds_.set(number(robot), *effects.colour, us);
  if (effects.save) store(robot, values);
}

void RobotBodies::stop(int robot) {
  motors_.connect(number(robot), false, 0);
  motors_.forget_set_point(number(robot));
  motors_.set(number(robot), 0, 0, 0);
  leds_.put_out(number(robot));
}

}  // namespace arkmesh::sim_ode
