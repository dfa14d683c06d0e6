#include "sim_ode/host/battery.hpp"

#include <algorithm>

#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double motor_duty = 70;  // for which battery_motor_ma is given

}  // namespace

void BatterySettings::fields(const hal::Section& ode) {
  ode.field("battery_mah", battery_mah, {{0, 10'000}, "mAh", "charge of a full battery; 0: it never runs down"});
  ode.field("battery_idle_ma", battery_idle_ma, {{0, 1000}, "mA", "current at rest with the LED off"});
  ode.field("battery_motor_ma", battery_motor_ma, {{0, 1000}, "mA", "additional current per motor at a duty of 70"});
  ode.field("battery_led_ma", battery_led_ma,
            {{0, 1000}, "mA", "additional current per LED colour and step of brightness (0 to 3)"});
  ode.field("battery_empty_share", battery_empty_share,
            {{0, 1}, "", "voltage of an empty battery, as a share of a full one's; motors slow down in proportion"});
}

Batteries::Batteries(const BatterySettings& settings, const std::vector<RobotProfile>& profiles) : settings_(settings) {
  for (const RobotProfile& robot : profiles) robots_.push_back({robot.charge * settings.battery_mah * 3600});
}

void Batteries::spend(int robot, std::int64_t duties_us, std::int64_t light_us) {
  Robot& one = robots_[static_cast<std::size_t>(robot)];
  const auto drawn = static_cast<double>(duties_us - one.duties_us), lit = static_cast<double>(light_us - one.light_us);
  const double ma_us = settings_.battery_idle_ma * looks_every * tick_us +
                       settings_.battery_motor_ma * drawn / motor_duty + settings_.battery_led_ma * lit;
  one = {std::max(0.0, one.left_mas - ma_us * 1e-6), duties_us, light_us};
}

double Batteries::voltage(int robot) const {
  if (!run_down()) return 1;
  const double charge = robots_[static_cast<std::size_t>(robot)].left_mas / (settings_.battery_mah * 3600);
  return settings_.battery_empty_share + (1 - settings_.battery_empty_share) * charge;
}

}  // namespace arkmesh::sim_ode
