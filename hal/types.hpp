// The vocabulary of a lab: time, places, robots, what is said to them and what is seen of them.
// Plain values only; no behaviour, no library types.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace arkmesh::hal {

// Time since the experiment began. Never wall time.
using LabTime = std::chrono::microseconds;

using RobotId = std::uint32_t;

// Arena frame: metres, origin at the arena's centre, +x east, +y north; heading from +x, counter-clockwise, (-pi, pi].
struct Pose {
  double x_m = 0;
  double y_m = 0;
  double heading_rad = 0;
};

// The eight colours a camera tells apart: bit 0 red, bit 1 green, bit 2 blue. Unknown: it cannot tell, not even whether
// the LED is lit.
enum class Led : std::uint8_t {
  off = 0,
  red = 1,
  green = 2,
  yellow = 3,
  blue = 4,
  magenta = 5,
  cyan = 6,
  white = 7,
  unknown = 8
};

// Of a message's byte.
constexpr Led led_of(unsigned byte) {
  return byte <= static_cast<unsigned>(Led::unknown) ? static_cast<Led>(byte) : Led::unknown;
}

struct Point {
  double x_m = 0, y_m = 0;
};

// Something seen from above, in its own frame.
struct Shape {
  double radius_m = 0;         // of a disc around the origin; 0: a polygon
  std::vector<Point> corners;  // of a polygon that does not cross itself, counter-clockwise
};

// Stays where it is.
struct Obstacle {
  Shape shape;
  Pose pose;
};

// Robots can push it.
struct MovableObject {
  std::string name;  // unique in its arena
  Shape shape;
  Pose start;
  double mass_kg = 0.05;
  double friction = 0.1;  // Coulomb's, with the table
};

struct ObjectObservation {
  Pose pose;
  float confidence = 1;  // 0..1: the position is right
  LabTime age{0};        // stamp of the frame minus time of the last true observation
};

struct Observation {
  RobotId robot = 0;
  Pose pose;
  Led led = Led::off;
  float confidence = 1;  // 0..1: position and id are right
  LabTime age{0};        // stamp of the frame minus time of the last true observation
  // Standard deviation of the heading's noise, for who judges whether it changes; pi: it is not known. An error that
  // stays the same, as where the LED is, does not count. Not recorded.
  float heading_noise_rad = 3.1415927f;
};

struct PoseFrame {
  LabTime stamp{0};
  std::uint32_t number = 0;                // counts from 0; a gap is a lost frame
  std::vector<Observation> robots;         // ascending id, each id at most once
  std::vector<ObjectObservation> objects;  // all of the arena's, in the order of ArenaInfo::objects
};

// As a receiver: all robots of an arena.
inline constexpr RobotId everyone = 0xFFFF'FFFF;

// Nine bytes that a scenario and its robots' program agree on, and the type by which the program knows them.
struct WholeMessage {
  std::uint8_t type = 0;  // 0..127
  std::array<std::uint8_t, 9> data{};
  bool operator==(const WholeMessage&) const = default;
};

// Three numbers of 24 bits, most significant byte first, as programs read that expect something else in each third.
constexpr std::array<std::uint8_t, 9> in_three_groups(const std::array<std::uint32_t, 3>& numbers) {
  std::array<std::uint8_t, 9> out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(numbers[i / 3] >> (16 - 8 * (i % 3)));
  return out;
}

// What is said to a robot: a word (kind and value), or a whole message. `slot` names a register of the receiver: what
// is newer replaces what is older and unsent in the same slot, so what excludes each other shares a slot. Limits:
// ArenaInfo.
struct ToRobot {
  RobotId robot = 0;  // `everyone` with a whole message only
  std::uint8_t slot = 0;
  std::uint8_t kind = 0;
  std::uint32_t value = 0;              // of at most 24 bits
  std::optional<WholeMessage> whole{};  // instead of kind and value
};

struct FromRobot {
  RobotId robot = 0;
  std::uint8_t kind = 0;
  std::int32_t value = 0;
};

// What can be said to all robots at once. All but `reset` and `broadcast` set a register, of which the newest counts:
// what the robots should do from now on.
struct FleetCommand {
  enum class Kind : std::uint8_t { run, pause, reset, sleep, voltage, charge, broadcast };
  Kind kind = Kind::run;
  std::uint8_t type = 0;               // broadcast only: infrared message type 0..127
  std::array<std::uint8_t, 9> data{};  // broadcast only
};

// A robot that was not seen to stand although it should.
struct NotStanding {
  enum class Why : std::uint8_t {
    not_told,      // the word has not gone out yet
    not_yet,       // it was told, and has not been looked at for long enough since
    moving,        // more than a camera's noise explains
    not_in_sight,  // nobody knows what it does
    not_named,     // no camera has seen it and known its id, since the lab began
  };
  RobotId robot = 0;
  Why why = Why::not_told;
};

// What became of the messages offered to robots, in totals since the arena began.
struct Airtime {
  std::uint64_t offered = 0;   // ToRobot values offered
  std::uint64_t sent = 0;      // went on the air
  std::uint64_t replaced = 0;  // overwritten by a newer one before they went on the air
  std::uint64_t refused = 0;   // unknown robot, or outside the limits of ArenaInfo
  std::uint64_t not_sent = 0;  // accepted by an arena that talks to nobody (null, replay)
  std::uint64_t waiting = 0;   // not a total: registers that wait for airtime now
};

}  // namespace arkmesh::hal
