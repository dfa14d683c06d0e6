// Finds duties at which each robot turns and goes straight as it should, all robots at once: tells a robot to move,
// looks at its path, changes a duty, looks again. The robots run hal/platforms/kilobot/firmware/calibrate_motors.c and
// have ids of their own. Pure: pictures come in, messages go out.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "hal/types.hpp"
#include "tracker/follow/not_given.hpp"
#include "tracker/identity/announcements.hpp"
#include "tracker/identity/motion_log.hpp"
#include "tracker/identity/open_ground.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

struct MotorSettings {
  double width_m = 1, height_m = 1;  // of the arena: nobody is sent into a wall
  double body_radius_m = not_given;  // of a robot
  int first_duty = 60;               // of every motor, to begin with
  int min_duty = 40, largest_duty = 110;
  double measure_m = 0.015;      // what ARK's limits are given in: its robot's radius
  hal::LabTime settle{500'000};  // from a message until pictures show what it does
  double max_per_robot_s = 900;  // then a robot is given up
};

class MotorCalibrator {
 public:
  enum class Stage : std::uint8_t { left, right, aiming, straight, done, failed };
  struct Duties {
    int turn_left = 0, turn_right = 0, straight_left = 0, straight_right = 0;
  };
  struct Robot {
    Stage stage = Stage::left;
    Duties duties;
    double turn_left_rad_s = 0, turn_right_rad_s = 0;  // as last measured
    double straight_m_s = 0, straight_turn_rad_s = 0;  // counter-clockwise
    bool round = true;                                 // both turns fit a circle
    bool stored = false;                               // it shows that it has stored them
    int changes = 0;                                   // of duties so far
    std::string why;                                   // it failed
  };

  // `robots` ascending; at most 256.
  MotorCalibrator(MotorSettings settings, std::span<const hal::RobotId> robots);

  // Stamps ascending. Robots that are missing, uncertain or not seen now wait.
  void on_frame(const hal::PoseFrame& frame);
  // To single robots, since the last call; kinds 1 to 5.
  std::vector<hal::ToRobot> take_messages() { return std::exchange(messages_, {}); }
  // To all: store what was found.
  std::optional<Question> question() const { return storing_ ? announcements_.message() : std::nullopt; }
  bool finished() const { return finished_; }

  const std::map<hal::RobotId, Robot>& robots() const { return robots_; }
  bool storing() const { return storing_; }
  const hal::Counters& counters() const { return counters_; }

 private:
  enum class Check : std::uint8_t { moving, steady };
  // What it does on the way to a place with more room, in the middle of a stage.
  enum class Errand : std::uint8_t { none, turning, walking };
  struct Trial {
    MotionLog log;
    Check check = Check::moving;
    int bad_checks = 0;                   // in a row
    std::optional<hal::LabTime> told_at;  // what it does now
    hal::LabTime said_at{0};              // its last message
    std::optional<hal::LabTime> first_seen;
    double aim_rad = 0;
    Errand errand = Errand::none;
    int contacts = 0;         // that ended a trial, in this stage
    bool early_look = false;  // at this straight, before its end
  };

  void step(hal::RobotId id, Robot& robot, Trial& trial, const hal::Observation& seen, const Places& places,
            hal::LabTime now);
  void look_at_turn(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now);
  void look_at_straight(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now);
  void meet(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now);
  void begin_errand(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now);
  void run_errand(hal::RobotId id, Robot& robot, Trial& trial, const hal::Pose& pose, const Places& places,
                  hal::LabTime now);
  void aim(hal::RobotId id, Robot& robot, Trial& trial, const hal::Pose& pose, const Places& places, hal::LabTime now);
  void change(hal::RobotId id, Robot& robot, Trial& trial, int left_by, int right_by, hal::LabTime now);
  void enter(hal::RobotId id, Robot& robot, Trial& trial, Stage stage, hal::LabTime now);
  void fail(hal::RobotId id, Robot& robot, Trial& trial, std::string why, hal::LabTime now);
  void tell(hal::RobotId id, const Robot& robot, Trial& trial, hal::LabTime now);
  void begin_again(Trial& trial, hal::LabTime now);
  void store(const hal::PoseFrame& frame);

  MotorSettings settings_;
  OpenGround ground_;
  hal::Counters counters_;
  std::map<hal::RobotId, Robot> robots_;
  std::map<hal::RobotId, Trial> trials_;
  std::vector<hal::ToRobot> messages_;
  Announcements announcements_;
  bool storing_ = false, finished_ = false;
  int store_rounds_ = 0;
};

std::string_view name_of(MotorCalibrator::Stage stage);

}  // namespace arkmesh::tracker
