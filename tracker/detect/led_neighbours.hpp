// LEDs judged by the other robots of a picture. Blue and magenta: cameras see the two at hues that differ from arena to
// arena, but one camera sees all robots' LEDs alike. White: robots mirror one lamp on one side.
#pragma once

#include <span>

#include "tracker/detect/detection.hpp"

namespace arkmesh::tracker {

// Where an LED can be, and a coin cell's usual rim: parts of a robot's radius.
inline constexpr double nearest_led = 0.76, farthest_led = 0.98, usual_cell = 0.65;
// White or off with less confidence is unknown. Of white spots below it in rendered rooms more than half are mirrored
// lamps; of what is called off below it on white arenas all are lit, on grey arenas hardly one.
inline constexpr float least_sure = 0.2F;

// Where lit LEDs between cyan and red form groups of hue with gaps between them, a group of two robots or more has one
// colour, that of its median; a border through a group is moved into the gap beside it. A robot whose hue stands alone
// keeps what its own light says. `robots` are those of one picture.
void judge_beside_others(std::span<Detection*> robots);

// White must be earned, because lamps mirrored by cells, holders and unlit domes are white, too: less than least_sure,
// nearer to the centre than an LED lies, or not far out where most of the robots' mirrored light lies, it becomes
// unknown, and so does the direction.
void doubt_white(std::span<Detection*> robots);

// Nothing is known of the LED, nor of where it is.
void forget_led(Detection& robot);

}  // namespace arkmesh::tracker
