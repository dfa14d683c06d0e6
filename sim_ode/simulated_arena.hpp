// A simulated arena as those see it who play the hardware around it: what cameras would see, a real overhead
// controller's place, hands that move robots. Labs never get this: they see an Arena.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "hal/platforms/kilobot/message.hpp"
#include "sim_ode/host/robot_output.hpp"

namespace arkmesh::sim_ode {

// An infrared message that an overhead controller has sent; times are microseconds of lab time.
struct Transmission {
  std::int64_t start_us = 0, end_us = 0;
  hal::kilobot::Message message;
  bool clean = true;  // false: distorted, nobody can decode it, but it is light all the same
};

// Says what is on the air from above, in place of the arena's own composites.
class OverheadSource {
 public:
  virtual ~OverheadSource() = default;
  // Appends the messages that ended by `until_us` and that no earlier call has told of, in order of time. Called at
  // each robot tick.
  virtual void sent_until(std::int64_t until_us, std::vector<Transmission>& out) = 0;
  // Whether its light shines at some time in [from_us, to_us), as far as can be known now; the span may lie ahead.
  virtual bool on_air(std::int64_t from_us, std::int64_t to_us) const = 0;
};

class SimulatedArena : public hal::Arena {
 public:
  // Robots are named by their number 0..robots-1 here, whatever ids they believe to have.
  struct Seen {
    hal::Pose pose;                      // in the exposure's middle
    hal::Pose moved;                     // by so much while it lasted
    float red = 0, green = 0, blue = 0;  // of the LED, 0..1, mean over the exposure
    bool in_arena = true;
    bool powered = true;
    double led_bearing_rad = hal::kilobot::led_bearing_rad;  // from its heading, counter-clockwise
  };
  // What is true now, seen by an eye that was open for the last `exposure`. One entry per robot.
  virtual void look(hal::LabTime exposure, std::vector<Seen>& out) const = 0;

  // Hands. A robot off the arena hears nobody and touches nothing; its program runs on.
  virtual void take_off(int robot) = 0;
  // Empty when the robot can stand there, else why not, as the end of a sentence. Also puts down robots that are off
  // the arena.
  virtual std::string put(int robot, const hal::Pose& pose) = 0;
  // Dead: dark, deaf and still. Switched on again it begins as after power-up.
  virtual void set_power(int robot, bool on) = 0;
  // The id in a robot's EEPROM as it is now (kilo_uid).
  virtual std::uint16_t id_of(int robot) const = 0;
  // What a Thymio's proximity sensor reads, as Aseba's prox.horizontal; none: no such sensor.
  virtual std::optional<std::int16_t> prox(int robot, int sensor) const = 0;
  // Flash pages that the robot's boot loader has written so far.
  virtual std::uint64_t pages_written(int robot) const = 0;
};

struct SimulatedArenaOptions {
  OverheadSource* overhead = nullptr;  // outlives the arena; none: the arena's own composites
  std::vector<std::uint16_t> ids;      // kilo_uid by robot; empty: 0, 1, 2, ...
  RobotOutput output = {};             // where what robots say goes
  bool hostile = false;                // robots also receive what HostileAir makes
};

// As make_ode_arena (same keys, same streams), with the hardware's side open. arena.pace must be 0.
std::unique_ptr<SimulatedArena> make_simulated_arena(const hal::Section& arena, const std::string& lab,
                                                     std::uint64_t seed, const SimulatedArenaOptions& options);

}  // namespace arkmesh::sim_ode
