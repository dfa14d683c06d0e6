// The hardware abstraction: an arena full of robots, real or simulated. Above this file nobody can tell which.
// Everything here is single-threaded: call it from the thread that made the arena.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"
#include "hal/robot/robot_kind.hpp"
#include "hal/stop_request.hpp"
#include "hal/time/clock.hpp"
#include "hal/time/wall_time.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

// What an arena is and carries, with what its robots are. Constant for the arena's life.
struct ArenaInfo : RobotKind {
  std::string name;               // the lab's name
  std::string platform;           // as arena.use names it
  double width_m = 1;             // along x
  double height_m = 1;            // along y
  std::vector<RobotId> robots;    // ids that are expected, ascending
  bool can_wait = true;           // false: lab time passes by itself, as on a testbed
  bool starts_with_labs = false;  // starts when all labs are there, and passes no boundary before their states came
  LabTime frame_period{100'000};  // frames are stamped n * frame_period, n = 0, 1, ...
  std::vector<Obstacle> obstacles;
  std::vector<MovableObject> objects;
};

// Where the robots are. Cameras, a simulator, a log: the same thing.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  // The newest frame that no earlier call has returned; nothing when there is none. Never blocks.
  // After advance_to(t) its stamp is at most t. Frames that nobody took are skipped and counted.
  virtual std::optional<PoseFrame> latest() = 0;
};

// What robots lack, as far as an arena knows. One that speaks to nobody, or whose robots hear all, knows of nothing.
struct NotHeard {
  std::uint64_t openings = 0;         // of the line to the robots, in all: what it was saying before may be lost
  std::set<std::uint8_t> broadcasts;  // their types: given up since the last call
  std::set<RobotId> words;            // whom they were for, likewise
  std::set<RobotId> restarted;        // who may have begun anew since, with nothing that it was told
};

// The way to the robots. Airtime is scarce: one register per (robot, slot), newest wins, never a queue.
class RobotLink {
 public:
  virtual ~RobotLink() = default;
  // Replaces the registers named. Each offer is sent once. Messages outside ArenaInfo's limits are refused and counted.
  // Never blocks.
  virtual void offer(std::span<const ToRobot> newest) = 0;
  // What became of all that was offered so far. Asking changes nothing.
  virtual Airtime airtime() const = 0;
  // To the whole fleet, ahead of single robots' messages. What the robots should do (run, pause, sleep, voltage,
  // charge) is a register: the newest replaces one that was not said yet, and the arena says it again for as long as
  // robots may not have heard it. Words after which robots stand overtake what else waits; `run` does not. A reset is
  // done once; it leaves robots paused until `run`. A command that ArenaInfo does not list is refused and counted as
  // `fleet_command.refused.` and its name. Never blocks.
  virtual void command(const FleetCommand& command) = 0;
  // Each thing given up is told once; asking changes nothing else.
  virtual NotHeard not_heard() = 0;
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
  // still until a later time. Never blocks on wall time. False: not there yet, and lab time has not changed; call
  // serve() and then advance_to with the same t again, at next_service() at the latest. An arena that can wait is
  // always there at once. One that cannot wait anchors its clock at the first call with t > 0. Throws
  // std::runtime_error with one sentence when the arena is lost for good.
  virtual bool advance_to(LabTime t) = 0;
  // Serves the devices and looks at the cameras, as far as they want it now. No lab time passes. Quick; call it also
  // while the lab waits for something else.
  virtual void serve() = 0;
  // When serve(), or an advance_to or end() that was answered with false, is wanted at the latest. TimePoint::max():
  // the arena needs nothing. TimePoint::min(): at once; an arena that computes its own time (the emulated one) answers
  // so while it is not there yet, because only calls let its time pass.
  virtual TimePoint next_service() const = 0;
  // What keeps an advance_to that was answered with false, other than the passing of time, as the end of a sentence:
  // "the testbed: the cameras give no picture". Empty: nothing.
  virtual std::string waiting_for() const = 0;
  // The run is over: what waits for single robots is dropped, robots are told to stand unless they are told something
  // else after which they do, until they were seen to, and then the way to the robots falls silent. Never blocks.
  // False: not silent yet; serve(), and call again at next_service() at the latest. Becomes true after some 10 s in any
  // case. No advance_to afterwards.
  virtual bool end() = 0;
  // While robots should stand, those that were not seen to, ascending; also after end(). None: all were seen to, or the
  // arena computes its robots and so knows that they obey, or it has none to tell.
  virtual std::vector<NotStanding> not_standing() const = 0;
  // Everything dropped, late, refused or failed inside the arena, by reason.
  virtual const Counters& counters() const = 0;
};

// Waits until the arena is at lab time t, for those who have nothing else to do meanwhile: set-up procedures, tools and
// tests. Says in the log every five seconds what is waited for. `stop` is asked every few milliseconds; a wish throws
// std::runtime_error. `wall` is the arena's.
void advance(Arena& arena, LabTime t, StopRequest& stop = nobody_stops(), WallTime& wall = machine_time());
// The same for Arena::end.
void end(Arena& arena, WallTime& wall = machine_time());
// Until the arena's next_service(), but for 20 ms at most, because somebody may want to stop.
void wait_for_service(const Arena& arena, WallTime& wall = machine_time());
// `why`, and what the arena was waiting for when that happened: "stopped by the operator; waited for the testbed: ...".
std::string stopped(std::string_view why, const Arena& arena);

}  // namespace arkmesh::hal
