// What robots are besides their programs: motors, LED, sensors, battery, and the EEPROM that keeps their values.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/host/led_lights.hpp"
#include "sim_ode/host/motors.hpp"
#include "sim_ode/host/turns/firmware.hpp"

namespace arkmesh::sim_ode {

// Readings are 0..1023.
struct RobotSensors {
  std::function<std::int16_t(int robot)> light;  // empty: dark
  // Whether a message arrives at lab time at_us; programs read -1 then. Empty: never.
  std::function<bool(int robot, std::int64_t at_us)> receiving;
  // Its battery's voltage as a share of a full one's. Empty: batteries never run down.
  std::function<double(int robot)> voltage;
  // What it says to its lab. Empty: nobody hears.
  std::function<void(int robot, std::uint8_t kind, std::int32_t value)> say;
  // What a proximity sensor reads, if the robot has it. Empty: none.
  std::function<std::optional<std::int16_t>(int robot, int sensor)> prox = {};
  bool by_argos = false;  // what their receivers measure, and which types they pass on: infrared = "argos"
};

class RobotBodies {
 public:
  // `motors` and `leds` outlive the bodies. Robots' ids are 0, 1, 2, ... unless `ids` holds others. They are `robots`
  // of the arena's from number `first` on, and are counted from 0 here.
  RobotBodies(int robots, Motors& motors, LedLights& leds, RobotSensors sensors, const std::string& lab,
              std::uint64_t seed, const std::vector<std::uint16_t>& ids, int first = 0);

  // In the arena.
  int number(int robot) const { return first_ + robot; }

  // What the EEPROM holds.
  RobotValues values(int robot) const { return {uid_[index(robot)], motors_.calibration(number(robot))}; }
  void store(int robot, const RobotValues& values) {
    uid_[index(robot)] = values.uid;
    motors_.calibration(number(robot)) = values.duties;
  }

  // What a command does, `us` after the start of the present tick. `values` are those in the robot's memory.
  void apply(int robot, const Effects& effects, const RobotValues& values, std::int64_t us);
  void drive(int robot, std::uint8_t left, std::uint8_t right, std::int64_t us) {
    motors_.set(number(robot), left, right, us);
  }
  bool moves(int robot) const { return motors_.load(number(robot)) > 0; }
  // As it was when the present tick began.
  std::uint8_t colour(int robot) const { return leds_.colour(number(robot)); }
  void show(int robot, std::uint8_t colour, std::int64_t us) { leds_.set(number(robot), colour, us); }
  // Dark and still.
  void stop(int robot);

  // Whether a message arrives at lab time at_us: no sensor can be read then.
  bool receives(int robot, std::int64_t at_us) const {
    return sensors_.receiving && sensors_.receiving(number(robot), at_us);
  }
  std::int16_t light(int robot) const { return sensors_.light ? sensors_.light(number(robot)) : std::int16_t{0}; }
  // False: nobody hears it.
  bool say(int robot, std::uint8_t kind, std::int32_t value) const {
    if (sensors_.say) sensors_.say(number(robot), kind, value);
    return sensors_.say != nullptr;
  }
  std::optional<std::int16_t> prox(int robot, int sensor) const {
    return sensors_.prox ? sensors_.prox(number(robot), sensor) : std::nullopt;
  }
  bool by_argos() const { return sensors_.by_argos; }
  std::int16_t voltage(int robot) const;
  std::int16_t temperature(int robot) const { return temperature_[index(robot)]; }
  std::uint8_t random_byte(int robot) { return static_cast<std::uint8_t>(hard_random_[index(robot)].next()); }

 private:
  static std::size_t index(int robot) { return static_cast<std::size_t>(robot); }

  int first_;
  Motors& motors_;
  LedLights& leds_;
  RobotSensors sensors_;
  std::vector<std::uint16_t> uid_;
  std::vector<std::int16_t> voltage_, temperature_;  // by robot
  std::vector<hal::RandomStream> hard_random_;
};

}  // namespace arkmesh::sim_ode
