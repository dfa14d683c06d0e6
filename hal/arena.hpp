// The hardware abstraction: an arena full of robots, real or simulated. Above this file nobody can tell which.
// Everything here is single-threaded: call it from the thread that made the arena.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/counters.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

// What an arena is and carries. Constant for the arena's life.
struct ArenaInfo {
  std::string name;               // the lab's name
  std::string platform;           // "ode", "replay", "null", "kilobot"
  double width_m = 1;             // along x
  double height_m = 1;            // along y
  std::vector<RobotId> robots;    // ids that are expected, ascending
  bool can_wait = true;           // false: lab time passes by itself, as in a room
  LabTime frame_period{100'000};  // frames are stamped n * frame_period, n = 0, 1, ...
  RobotId max_robot = 1022;       // largest addressable id
  std::uint8_t kinds = 16;        // ToRobot::kind is below this
  std::uint16_t values = 1024;    // ToRobot::value is below this
};

// Where the robots are. Cameras, a simulator, a log: the same thing.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  // The newest frame that no earlier call has returned; nothing when there is none. Never blocks.
  // After advance_to(t) its stamp is at most t. Frames that nobody took are skipped and counted.
  virtual std::optional<PoseFrame> latest() = 0;
};

// The way to the robots. Airtime is scarce: one register per (robot, slot), newest wins, never a queue.
class RobotLink {
 public:
  virtual ~RobotLink() = default;
  // Replaces the registers named. Each offer is sent once. Messages outside ArenaInfo's limits are refused and counted.
  // Returns the totals. Never blocks.
  virtual Airtime offer(std::span<const ToRobot> newest) = 0;
  // To the whole fleet, ahead of all registers. Never blocks.
  virtual void command(const FleetCommand& command) = 0;
  // What robots said since the last call. Always empty for Kilobots.
  virtual std::vector<FromRobot> heard() = 0;
};

class Arena {
 public:
  virtual ~Arena() = default;
  virtual const ArenaInfo& info() const = 0;
  virtual const Clock& clock() const = 0;
  virtual PoseSource& poses() = 0;
  virtual RobotLink& robots() = 0;
  // The one verb that lets lab time pass: handles every internal event with time <= t, in time order, and none after.
  // t never decreases; the same t again does nothing. Frame 0, stamped 0, is there after advance_to(0); robots stand
  // still until a later time. An arena that cannot wait anchors its clock at the first call with t > 0 and then blocks
  // until t. Throws std::runtime_error with one sentence when the arena is lost for good.
  virtual void advance_to(LabTime t) = 0;
  // Everything dropped, late, refused or failed inside the arena, by reason.
  virtual const Counters& counters() const = 0;
};

}  // namespace arkmesh::hal
