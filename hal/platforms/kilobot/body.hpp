// The measures of a Kilobot. Lengths are metres, bearings radians counter-clockwise from ahead, seen from above. Each
// stands here only, with its source and how far sources differ; who may not include this is given it in settings.
#pragma once

#include <cstdint>
#include <numbers>

namespace arkmesh::hal::kilobot {

// 33 mm diameter: Kilobot labs page, ARGoS kilobot_measures.h. Kilombo: 34 mm.
inline constexpr double body_radius_m = 0.0165;
// The edge of the board above the surface, as high as the legs are long: ARGoS kilobot_measures.h. Nobody else says.
inline constexpr double board_height_m = 0.0217;
// Two rigid legs at the rear, about one of which a robot turns while one motor is on, and how far the centre is ahead
// of the line between them. Kilombo, from the robot's PCB files: on a circle of 17 mm, 125.5 degrees from ahead. ARGoS
// has 25 mm and 9.2 mm in round numbers, whose legs lie on a circle of 15.5 mm.
inline constexpr double rear_legs_apart_m = 0.0277, rear_axle_m = 0.0099;
// The LED is at the front right near the rim. Measured in pictures of real robots, which differ by 0.03 in radius;
// another lab's robots may carry it elsewhere (ARK has 20 degrees in code that it never runs).
inline constexpr double led_bearing_deg = -44, led_bearing_rad = led_bearing_deg * std::numbers::pi / 180;
// Between robots, about that bearing. Ours, chosen between data: six straight drivers of a film lie 14 degrees from it
// (RMS, pushes included), and bearings of 35 to 72 degrees also 14.
inline constexpr double led_bearing_spread_rad = 15 * std::numbers::pi / 180;
inline constexpr double led_radius_m = 0.87 * body_radius_m;
// How far it is above the board. Ours: no source gives it; small surface-mounted ones are that high.
inline constexpr double led_above_board_m = 0.001;
// The sensor of ambient light: ARGoS kilobot_measures.h. The labs page warns that two makers put it in different
// places.
inline constexpr double light_sensor_bearing_rad = 100 * std::numbers::pi / 180, light_sensor_radius_m = 0.0145;
// As fast as any walks. About 1 cm/s (Rubenstein and others, ICRA 2012); ARGoS 11 mm/s at a usual duty, to 20 mm/s at
// the highest one that motors stand.
inline constexpr double fastest_m_s = 0.02;
// The robot's timer: 256 x 1024 cycles of 8 MHz (kilolib, timed). Its documentation says 1/32 s, simulators 1/31 s.
inline constexpr std::int64_t tick_us = 32'768;

}  // namespace arkmesh::hal::kilobot
