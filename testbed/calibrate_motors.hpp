// Set-up procedure `calibrate-motors`: duties at which each robot in an arena turns and goes straight as it should.
// Robots run firmware/calibrate_motors.c and have ids of their own.
#pragma once

#include <map>
#include <vector>

#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "testbed/set_up_arena.hpp"
#include "tracker/identity/motor_calibrator.hpp"

namespace arkmesh::testbed {

inline constexpr std::size_t max_robots_to_calibrate = 256;

struct CalibrateMotorsSettings {
  std::vector<hal::RobotId> ids;  // ascending, at most max_robots_to_calibrate
  int first_duty = 60;            // of 255
  double max_s = 900;             // then a robot is given up
};

struct CalibrateMotorsReport {
  std::map<hal::RobotId, tracker::MotorCalibrator::Robot> robots;  // those that were found
  std::vector<hal::RobotId> missing;
  std::size_t stored = 0;  // robots that show that they have stored good duties
  double took_s = 0;
  bool simulated = false;  // the arena is no real one
};

CalibrateMotorsReport calibrate_motors(SetUpArena& arena, const CalibrateMotorsSettings& settings,
                                       hal::StopRequest& stop, hal::Progress& progress);

}  // namespace arkmesh::testbed
