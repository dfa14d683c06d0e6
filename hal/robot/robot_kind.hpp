// What a robot is: one value for each make, stated where the make is known and handed out by its arena. Everybody else
// reads it and names no make.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::hal {

// To whom an arena carries whole messages. An overhead controller lights the whole arena; a simulator can do otherwise.
enum class WholeMessages : std::uint8_t { to_nobody, to_everyone, to_each };

// How a robot moves, when it moves as fast as it can.
struct RobotDrive {
  enum class Way : std::uint8_t {
    unknown,
    vibration,    // only its own program moves it
    differential  // two wheels, which can be given set points
  } way = Way::unknown;
  double speed_m_s = 0;
  double wheels_apart_m = 0;  // differential
  double axle_behind_m = 0;   // about what it turns: so far behind the body's centre
};

// The defaults allow whatever the values can hold and claim nothing.
struct RobotKind {
  std::string make = "robot";  // as configuration files spell it
  double body_radius_m = 0;    // seen from above, a disc; positive for every platform
  double height_m = 0;         // above the arena, of what cameras look for
  RobotDrive drive;
  // How cameras find it and learn who it is.
  enum class Seen : std::uint8_t { unknown, disc_and_led, marker } seen_by = Seen::unknown;
  // What it can be told.
  RobotId max_robot = 1'000'000'000;  // largest addressable id
  std::uint8_t kinds = 255;           // ToRobot::kind is below this
  std::uint32_t values = 1 << 24;     // ToRobot::value is below this
  double words_per_s = 0;             // to all robots together, at most; 0: nobody says
  // How words lie in the messages that robots receive (hal/platforms/kilobot/layout.hpp); 0 bits of id: nobody says.
  std::uint8_t id_bits = 0, kind_bits = 0, message_type = 0;
  WholeMessages whole = WholeMessages::to_nobody;
  std::vector<FleetCommand::Kind> commands;  // those that the platform carries; others are refused
  // What arkmesh's own program on it tells its lab, by FromRobot::kind; programs of others may tell other things.
  std::vector<std::string> says;

  bool can_be_driven() const { return drive.way == RobotDrive::Way::differential; }
};

}  // namespace arkmesh::hal
