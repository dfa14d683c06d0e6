// What robots of CRE are told, and when. Airtime is scarce: a flying robot has one message for each reading, all of
// them in the same frame, so that the overhead controller is silent in between and robots hear each other; a ground
// robot is told what has changed, and again at a low rate while it matters.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/types.hpp"
#include "scenarios/cre/places.hpp"

namespace arkmesh::scenarios::cre {

// What a robot shows of itself. A ground robot that shows anything but `walking` does what it has heard.
inline constexpr hal::Led walking = hal::Led::off, for_north = hal::Led::red, for_south = hal::Led::blue;

// The region that a flying robot shows itself committed to.
std::optional<Region> opinion_of(hal::Led led);

// Where the wall is for a robot that has walls in these sectors (wall_sensor.hpp): enum cre_wall. Up to two blocked
// sectors are none.
std::uint8_t wall_of(std::uint8_t sectors);

// A reading for a flying robot.
hal::ToRobot reading(hal::RobotId robot, const Sight& sight, std::uint8_t wall);

// A flying robot as ground robots hear it.
struct Speaker {
  hal::Pose in_ground;
  Region region;
};
// The nearest of those within `radius_m` that are outside their region; null when there is none.
const Speaker* nearest_speaker(const std::vector<Speaker>& speakers, const hal::Pose& in_ground, double radius_m);

// Decides what ground robots are told. `in_ground` headings are their compass.
class GroundMessages {
 public:
  explicit GroundMessages(hal::LabTime repeat) : repeat_(repeat) {}
  // `speaker` may be null. Only a robot that walks is told.
  std::optional<hal::ToRobot> heard(hal::LabTime now, hal::RobotId robot, const hal::Pose& in_ground, hal::Led led,
                                    const Speaker* speaker);

 private:
  hal::LabTime repeat_;
  std::vector<hal::LabTime> heard_;  // when it was told last, by robot id
};

}  // namespace arkmesh::scenarios::cre
