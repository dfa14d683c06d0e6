#include "sim_ode/host/robot_bodies.hpp"

namespace arkmesh::sim_ode {
namespace {

// Battery and temperature: Kilombo's values, and how far a robot's may lie off them (our assumption).
constexpr int nominal_voltage = 876, voltage_spread = 30, nominal_temperature = 314, temperature_spread = 4;

}  // namespace

RobotBodies::RobotBodies(int robots, Motors& motors, LedLights& leds, RobotSensors sensors, const std::string& lab,
                         std::uint64_t seed, const std::vector<std::uint16_t>& ids)
    : motors_(motors), leds_(leds), sensors_(std::move(sensors)) {
  hal::RandomStream sensing(seed, lab + "/ode/sensors");
  const auto around = [&sensing](int nominal, int spread) {
    return static_cast<std::int16_t>(nominal - spread +
                                     static_cast<int>(sensing.below(static_cast<std::uint64_t>(2 * spread + 1))));
  };
  for (int i = 0; i < robots; ++i) {
    uid_.push_back(ids.empty() ? static_cast<std::uint16_t>(i) : ids.at(index(i)));
    voltage_.push_back(around(nominal_voltage, voltage_spread));
    temperature_.push_back(around(nominal_temperature, temperature_spread));
    hard_random_.emplace_back(seed, lab + "/ode/rand_hard", static_cast<std::uint64_t>(i));
  }
}

void RobotBodies::apply(int robot, const Effects& effects, const RobotValues& values, std::int64_t us) {
  if (effects.outputs != Effects::Outputs::keep)
    motors_.connect(robot, effects.outputs == Effects::Outputs::connect, us);
  if (effects.duties) motors_.set(robot, effects.duties->left, effects.duties->right, us);
  if (effects.colour) leds_.set(robot, *effects.colour, us);
  if (!effects.save) return;
  uid_[index(robot)] = values.uid;
  motors_.calibration(robot) = values.duties;
}

void RobotBodies::stop(int robot) {
  motors_.connect(robot, false, 0);
  motors_.set(robot, 0, 0, 0);
  leds_.put_out(robot);
}

}  // namespace arkmesh::sim_ode
