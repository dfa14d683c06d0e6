// The limits are those of ARK's calibration, in multiples of its robot's radius (15 mm), with three differences: speeds
// over ground scale with it like all others; which motor is too strong follows from the side to which the path bends;
// and straights are aimed where there is room.
#include "tracker/identity/motor_calibrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tracker/follow/motion.hpp"

namespace arkmesh::tracker {
namespace {

enum Kind : std::uint8_t { turn_left = 1, turn_right = 2, stop = 3, straight = 4, right_duty = 5 };
constexpr std::uint8_t store_turns_type = 110, store_straights_type = 111;

// Speeds over path, multiples of the measure by second: nearly still; turns and straights as they should be; far too
// fast.
constexpr double crawl = 0.25, low = 0.70, turn_high = 0.95, straight_high = 1.10, dash = 1.5;
constexpr double net_low = 0.60, net_high = 14.0 / 15;  // over ground
constexpr double moving_s = 1, judged_s = 2.5, steady_s = 4, straight_s = 15, net_s = 10, early_s = 6;
constexpr double shortest_turn_s = 8, longest_turn_s = 15;
constexpr double back_near = 0.25, back_away = 1.0;  // of the measure
constexpr double off_chord = 0.9;
constexpr int checks_in_a_row = 10;
constexpr double bend_rad_s = 0.035;           // 2 degrees a second: worth a change before the end
constexpr double bend_per_duty_rad_s = 0.012;  // what one step of one motor does to a straight, roughly
constexpr double min_way_m = 0.17;             // with less it looks for another place first
constexpr int max_contacts = 60;
constexpr hal::LabTime walk_lasts{7'000'000}, turn_lasts{20'000'000};
constexpr hal::LabTime second_copy{600'000};
constexpr hal::LabTime store_lasts{1'000'000};
constexpr int max_store_rounds = 5;

int change_for(double speed, double high) {
  if (speed < crawl) return 3;
  if (speed < low) return 1;
  if (speed > dash) return -5;
  return speed > high ? -1 : 0;
}

}  // namespace

MotorCalibrator::MotorCalibrator(MotorSettings settings, std::span<const hal::RobotId> robots)
    : settings_(settings),
      ground_(settings.width_m, settings.height_m, settings.body_radius_m, 2 * settings.measure_m) {
  const int duty = settings_.first_duty;
  for (hal::RobotId id : robots.first(std::min<std::size_t>(robots.size(), 256))) {
    robots_[id].duties = {duty, duty, duty, duty};
    trials_[id];
  }
}

void MotorCalibrator::on_frame(const hal::PoseFrame& frame) {
  if (finished_) return;
  if (storing_) return store(frame);
  Places places;
  for (const hal::Observation& seen : frame.robots) places.emplace_back(seen.robot, seen.pose);
  for (const hal::Observation& seen : frame.robots) {
    const auto at = robots_.find(seen.robot);
    if (at == robots_.end() || seen.confidence <= 0 || seen.age > hal::LabTime{0}) continue;
    step(seen.robot, at->second, trials_[seen.robot], seen, places, frame.stamp);
  }
  storing_ =
      std::all_of(robots_.begin(), robots_.end(), [](const auto& robot) { return robot.second.stage >= Stage::done; });
}

void MotorCalibrator::step(hal::RobotId id, Robot& robot, Trial& trial, const hal::Observation& seen,
                           const Places& places, hal::LabTime now) {
  if (!trial.told_at) {
    trial.first_seen = now;
    enter(id, robot, trial, Stage::left, now);
  }
  // again when the first copy may have been lost, and then as often as there is room on the air for all: two blocks
  // each, 54 a second
  const hal::LabTime again =
      std::max(hal::LabTime{2'000'000}, hal::LabTime{static_cast<std::int64_t>(40'000 * robots_.size())});
  const bool is_second = trial.said_at == *trial.told_at && now - trial.said_at >= second_copy;
  if (is_second || now - trial.said_at >= again) tell(id, robot, trial, now);
  if (robot.stage >= Stage::done) return;
  if (now - *trial.first_seen > hal::LabTime{static_cast<std::int64_t>(settings_.max_per_robot_s * 1e6)})
    return fail(id, robot, trial, fmt::format("no good duties in {:.0f} s", settings_.max_per_robot_s), now);
  if (now - *trial.told_at < settings_.settle) return;
  if (trial.errand != Errand::none) return run_errand(id, robot, trial, seen.pose, places, now);
  if (robot.stage == Stage::aiming) return aim(id, robot, trial, seen.pose, places, now);
  // what it does now is not its motors' doing, or will soon not be
  if (ground_.touches(id, seen.pose, places)) return meet(id, robot, trial, now);
  if (robot.stage != Stage::straight && trial.log.lasted_s() == 0 && ground_.crowded(id, seen.pose, places))
    return meet(id, robot, trial, now);
  trial.log.add(now, seen.pose.x_m, seen.pose.y_m);
  robot.stage == Stage::straight ? look_at_straight(id, robot, trial, now) : look_at_turn(id, robot, trial, now);
}

void MotorCalibrator::look_at_turn(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now) {
  const double lasted_s = trial.log.lasted_s(), measure_m = settings_.measure_m;
  if (trial.check == Check::moving) {
    if (lasted_s < moving_s) return;
    const int by = change_for(trial.log.path_speed_m_s(moving_s) / measure_m, turn_high);
    if (by == 0)
      trial.check = Check::steady;
    else if (lasted_s >= judged_s)
      change(id, robot, trial, by, by, now);
    return;
  }
  if (lasted_s < steady_s) return;
  const double speed = trial.log.path_speed_m_s(steady_s) / measure_m;
  const int by = change_for(speed, turn_high);
  trial.bad_checks = by == 0 ? 0 : trial.bad_checks + 1;
  if (trial.bad_checks >= checks_in_a_row) return change(id, robot, trial, by, by, now);

  const auto circle = trial.log.circle();
  const bool is_round =
      circle.radius_m > measure_m / 2 && circle.radius_m < 1.5 * measure_m && circle.off_m < 0.15 * circle.radius_m;
  if (const auto back_s = trial.log.came_back_s(back_away * measure_m, back_near * measure_m)) {
    // it comes near before it is all the way round
    const double left_out =
        circle.radius_m > 0 ? std::min(0.5, back_near * measure_m / (2 * std::numbers::pi * circle.radius_m)) : 0;
    const double whole_s = *back_s / (1 - left_out);
    if (whole_s < shortest_turn_s) return change(id, robot, trial, -1, -1, now);
    const double rate = 2 * std::numbers::pi / whole_s;
    robot.round = robot.round && is_round;
    if (robot.stage == Stage::left) {
      robot.turn_left_rad_s = rate;
      return enter(id, robot, trial, Stage::right, now);
    }
    robot.turn_right_rad_s = -rate;
    return enter(id, robot, trial, Stage::aiming, now);
  }
  if (lasted_s < longest_turn_s) return;
  // at this speed it should have been back
  counters_.add("calibration.repeated.not_back");
  const int last = is_round ? 1 : -2;
  change(id, robot, trial, last, last, now);
}

void MotorCalibrator::look_at_straight(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now) {
  const double lasted_s = trial.log.lasted_s(), measure_m = settings_.measure_m;
  if (lasted_s < moving_s) return;
  if (trial.check == Check::moving) {
    const int by = change_for(trial.log.path_speed_m_s(moving_s) / measure_m, straight_high);
    if (by == 0)
      trial.check = Check::steady;
    else if (lasted_s >= judged_s)
      change(id, robot, trial, by, by, now);
    return;
  }
  // weakens the motor whose side it turns away from; strengthens the other one when it is slow anyway
  const double bend = trial.log.course_rate_rad_s();
  const auto straighten = [&] {
    const int steps = std::clamp(static_cast<int>(std::lround(std::abs(bend) / bend_per_duty_rad_s)), 1, 8);
    const bool is_slow = trial.log.path_speed_m_s(lasted_s) / measure_m < (low + straight_high) / 2;
    const int weaken = is_slow ? steps / 2 : (steps + 1) / 2, strengthen = steps - weaken;
    if (bend > 0)
      change(id, robot, trial, -weaken, strengthen, now);
    else
      change(id, robot, trial, strengthen, -weaken, now);
  };
  if (!trial.early_look && lasted_s >= early_s) {
    trial.early_look = true;
    if (std::abs(bend) > bend_rad_s) return straighten();
  }
  if (lasted_s < net_s) return;
  const double net = trial.log.net_speed_m_s() / measure_m;
  const bool too_slow = net<net_low, too_fast = net> net_high;
  trial.bad_checks = too_slow || too_fast ? trial.bad_checks + 1 : 0;
  if (trial.bad_checks >= checks_in_a_row) {
    // it moves and gets nowhere: the path is bent
    if (too_slow && trial.log.path_speed_m_s(net_s) / measure_m >= low) return straighten();
    const int by = too_slow ? 1 : -1;
    return change(id, robot, trial, by, by, now);
  }
  if (lasted_s < straight_s) return;
  if (trial.log.mean_off_chord_m() >= off_chord * measure_m || std::abs(bend) > bend_rad_s) return straighten();
  robot.straight_m_s = trial.log.net_speed_m_s();
  robot.straight_turn_rad_s = bend;
  enter(id, robot, trial, Stage::done, now);
}

void MotorCalibrator::meet(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now) {
  counters_.add("calibration.repeated.contact");
  if (++trial.contacts > max_contacts)
    return fail(id, robot, trial, "meets other robots or walls each time; give the robots more room", now);
  if (robot.stage == Stage::straight) return enter(id, robot, trial, Stage::aiming, now);
  begin_errand(id, robot, trial, now);
}

void MotorCalibrator::begin_errand(hal::RobotId id, Robot& robot, Trial& trial, hal::LabTime now) {
  trial.errand = Errand::turning;
  begin_again(trial, now);
  trial.told_at = now;
  tell(id, robot, trial, now);
}

// To where there is more room: turns to the freest way, walks, and goes on with what it was doing.
void MotorCalibrator::run_errand(hal::RobotId id, Robot& robot, Trial& trial, const hal::Pose& pose,
                                 const Places& places, hal::LabTime now) {
  const hal::LabTime lasted = now - *trial.told_at;
  if (trial.errand == Errand::turning) {
    trial.aim_rad = ground_.freest_way(id, pose, places).course_rad;
    if (std::abs(wrapped(trial.aim_rad - pose.heading_rad)) > 0.25 && lasted < turn_lasts) return;
    trial.errand = Errand::walking;
  } else {
    const bool blocked = lasted > 2 * settings_.settle &&
                         ground_.free_way_m(id, pose, pose.heading_rad, places) < settings_.body_radius_m;
    if (lasted < walk_lasts && !blocked) return;
    trial.errand = Errand::none;
  }
  trial.told_at = now;
  tell(id, robot, trial, now);
}

// Turns left until the way ahead is free; where there is none it goes elsewhere first.
void MotorCalibrator::aim(hal::RobotId id, Robot& robot, Trial& trial, const hal::Pose& pose, const Places& places,
                          hal::LabTime now) {
  const OpenGround::Way way = ground_.freest_way(id, pose, places);
  trial.aim_rad = way.course_rad;
  if (way.free_m < min_way_m) {
    counters_.add("calibration.repeated.no_way");
    if (++trial.contacts > max_contacts)
      return fail(id, robot, trial, "finds no free straight path; give the robots more room", now);
    return begin_errand(id, robot, trial, now);
  }
  const bool too_long = now - *trial.told_at > turn_lasts;
  if (std::abs(wrapped(trial.aim_rad - pose.heading_rad)) < 0.1 || too_long)
    enter(id, robot, trial, Stage::straight, now);
}

void MotorCalibrator::change(hal::RobotId id, Robot& robot, Trial& trial, int left_by, int right_by, hal::LabTime now) {
  Duties& duties = robot.duties;
  const auto add = [this](int& duty, int by) {
    const int before = duty;
    duty = std::clamp(duty + by, settings_.min_duty, settings_.largest_duty);
    return duty != before;
  };
  bool changed = false;
  switch (robot.stage) {
    case Stage::left:
      changed = add(duties.turn_left, left_by);
      break;
    case Stage::right:
      changed = add(duties.turn_right, right_by);
      break;
    default: {
      const bool left = add(duties.straight_left, left_by), right = add(duties.straight_right, right_by);
      changed = left || right;
    }
  }
  if (!changed)
    return fail(id, robot, trial,
                fmt::format("{} at a duty of {} already",
                            left_by > 0 || right_by > 0 ? "does not move enough" : "moves too much",
                            robot.stage == Stage::left    ? duties.turn_left
                            : robot.stage == Stage::right ? duties.turn_right
                                                          : duties.straight_left),
                now);
  ++robot.changes;
  counters_.add("calibration.changed");
  // a straight needs room anew
  if (robot.stage == Stage::straight) return enter(id, robot, trial, Stage::aiming, now);
  begin_again(trial, now);
  trial.told_at = now;
  tell(id, robot, trial, now);
}

void MotorCalibrator::enter(hal::RobotId id, Robot& robot, Trial& trial, Stage stage, hal::LabTime now) {
  if (stage == Stage::right || (stage == Stage::aiming && robot.stage == Stage::right)) trial.contacts = 0;
  trial.errand = Errand::none;
  robot.stage = stage;
  begin_again(trial, now);
  trial.told_at = now;
  tell(id, robot, trial, now);
}

void MotorCalibrator::fail(hal::RobotId id, Robot& robot, Trial& trial, std::string why, hal::LabTime now) {
  robot.why = std::move(why);
  counters_.add("calibration.failed");
  enter(id, robot, trial, Stage::failed, now);
}

void MotorCalibrator::begin_again(Trial& trial, hal::LabTime) {
  trial.log.clear();
  trial.check = Check::moving;
  trial.bad_checks = 0;
  trial.early_look = false;
}

void MotorCalibrator::tell(hal::RobotId id, const Robot& robot, Trial& trial, hal::LabTime now) {
  trial.said_at = now;
  const auto say = [&](Kind kind, int value, std::uint8_t slot = 0) {
    messages_.push_back({.robot = id, .slot = slot, .kind = kind, .value = static_cast<std::uint16_t>(value)});
  };
  const bool walks = trial.errand == Errand::walking;
  switch (walks ? Stage::straight : trial.errand == Errand::turning ? Stage::left : robot.stage) {
    case Stage::left:
    case Stage::aiming:
      say(turn_left, robot.duties.turn_left);
      break;
    case Stage::right:
      say(turn_right, robot.duties.turn_right);
      break;
    case Stage::straight:
      // the one that only sets a duty first
      say(right_duty, robot.duties.straight_right, 1);
      say(straight, robot.duties.straight_left);
      break;
    case Stage::done:
      say(stop, 0);
      break;
    case Stage::failed:
      say(stop, 1);
      break;
  }
}

// Until all who have something to store show that they have, or will not.
void MotorCalibrator::store(const hal::PoseFrame& frame) {
  for (const hal::Observation& seen : frame.robots)
    if (const auto at = robots_.find(seen.robot);
        at != robots_.end() && seen.led == hal::Led::green && store_rounds_ > 0)
      at->second.stored = true;
  if (announcements_.say(frame.stamp)) return;
  const bool all = std::all_of(robots_.begin(), robots_.end(), [](const auto& robot) {
    return robot.second.stage == Stage::failed || robot.second.stored;
  });
  if (all || store_rounds_ == max_store_rounds) {
    finished_ = true;
    return;
  }
  ++store_rounds_;
  for (auto& [id, robot] : robots_) tell(id, robot, trials_[id], frame.stamp);
  for (const std::uint8_t type : {store_turns_type, store_straights_type}) {
    announcements_.add({.type = type}, store_lasts);
  }
  announcements_.say(frame.stamp);
}

std::string_view name_of(MotorCalibrator::Stage stage) {
  constexpr std::string_view names[] = {"turns left", "turns right", "aims", "goes straight", "calibrated", "failed"};
  return names[static_cast<std::size_t>(stage)];
}

}  // namespace arkmesh::tracker
