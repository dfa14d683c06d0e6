#include "sim_ode/host/robot_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "hal/random.hpp"
#include "sim_ode/host/motors.hpp"

namespace arkmesh::sim_ode {
namespace {

constexpr double one_degree = std::numbers::pi / 180;
constexpr double not_said = std::numeric_limits<double>::quiet_NaN();

std::uint8_t to_duty(double duty) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(duty), 30L, 120L));
}

// A table of the file: what is not said stays as drawn.
struct RobotKeys {
  int id = -1;
  double speed_m_per_s = not_said, drift_deg_per_s = not_said;
  double turn_left_deg_per_s = not_said, turn_right_deg_per_s = not_said;
  std::vector<std::int64_t> duties;
  double turn_noise_deg_per_s = not_said, turn_noise_s = not_said;
  double dead_duty = not_said, start_duty = not_said, charge = not_said;
  double led_bearing_deg = not_said, led_bearing_error_deg = not_said, clock_slow = not_said, ir_gain = not_said;

  void fields(const hal::Section& robot) {
    robot.field("id", id,
                {.range = {0, 99'999},
                 .help = "id of the robot, or its number from 0 if the arena states no ids",
                 .sample = "3",
                 .required = true});
    robot.field("speed_m_per_s", speed_m_per_s, {{0, 0.1}, "m/s", "speed with both motors at their calibrated duty"});
    robot.field("drift_deg_per_s", drift_deg_per_s,
                {{-180, 180}, "deg/s", "turn rate at that duty, counter-clockwise"});
    robot.field("turn_left_deg_per_s", turn_left_deg_per_s,
                {{0, 360}, "deg/s", "turn rate with the left-turning motor alone"});
    robot.field("turn_right_deg_per_s", turn_right_deg_per_s,
                {{0, 360}, "deg/s", "turn rate with the right-turning motor alone"});
    robot.field("duties", duties,
                {{1, 255}, "", "calibrated duties: turn left, turn right, straight left, straight right"});
    robot.field("turn_noise_deg_per_s", turn_noise_deg_per_s,
                {{0, 90}, "deg/s", "s.d. of its slowly varying turn rate"});
    robot.field("turn_noise_s", turn_noise_s, {{0, 60}, "s", "correlation time of that turn rate"});
    robot.field("dead_duty", dead_duty, {{1, 255}, "", "duty below which a motor does not turn"});
    robot.field("start_duty", start_duty,
                {{0, 255}, "", "duty below which a motor at rest does not start, except by spinup_motors()"});
    robot.field("charge", charge, {{0, 1}, "", "charge of its battery at the start"});
    robot.field("led_bearing_deg", led_bearing_deg,
                {{-180, 180}, "deg", "bearing of its LED, counter-clockwise from ahead"});
    robot.field("led_bearing_error_deg", led_bearing_error_deg,
                {{0, 180}, "deg", "standard error of that bearing, for the tracker"});
    robot.field("clock_slow", clock_slow, {{-0.025, 0.025}, "", "relative slowness of its clock; negative: fast"});
    robot.field("ir_gain", ir_gain, {{0, 10}, "", "factor on the range of its messages"});
  }
  void check(const hal::Section& robot) const {
    if (!duties.empty() && duties.size() != 4)
      robot.refuse("duties", "must hold four duties: turn left, turn right, straight left, straight right");
  }

  void lay_over(const DriveSettings& settings, RobotProfile& out) const;
};

void RobotKeys::lay_over(const DriveSettings& settings, RobotProfile& out) const {
  using hal::kilobot::rear_legs_apart_m;
  const auto said = [](double value) { return !std::isnan(value); };
  const auto put = [&](double value, double& member) { member = said(value) ? value : member; };
  // forwards and turning are the mean and the difference of the sides
  const double mean =
      said(speed_m_per_s) ? speed_m_per_s - settings.speed_m_s : (out.straight_left_m_s + out.straight_right_m_s) / 2;
  const double half = said(drift_deg_per_s) ? drift_deg_per_s * one_degree * rear_legs_apart_m / 2
                                            : (out.straight_left_m_s - out.straight_right_m_s) / 2;
  if (said(speed_m_per_s) || said(drift_deg_per_s)) {
    out.straight_left_m_s = mean + half;
    out.straight_right_m_s = mean - half;
  }
  const auto side_of = [&](double deg_per_s) {
    return (deg_per_s * one_degree - settings.turn_rad_s) * rear_legs_apart_m;
  };
  put(side_of(turn_left_deg_per_s), out.pivot_left_m_s);
  put(side_of(turn_right_deg_per_s), out.pivot_right_m_s);
  if (!duties.empty())
    out.duties = {static_cast<std::uint8_t>(duties[0]), static_cast<std::uint8_t>(duties[1]),
                  static_cast<std::uint8_t>(duties[2]), static_cast<std::uint8_t>(duties[3])};
  put(turn_noise_deg_per_s * one_degree, out.turn_noise_rad_s);
  put(turn_noise_s, out.turn_noise_s);
  if (said(dead_duty)) out.dead_duty = static_cast<int>(dead_duty);
  if (said(start_duty)) out.start_duty = static_cast<int>(start_duty);
  put(charge, out.charge);
  put(led_bearing_deg * one_degree, out.led_bearing_rad);
  put(clock_slow, out.clock_slow);
  put(ir_gain, out.infrared_gain);
}

struct RobotsFile {
  std::vector<RobotKeys> robots;

  void fields(const hal::Section& file) { file.field("robot", robots); }
};

}  // namespace

std::vector<RobotProfile> draw_profiles(const DriveSettings& settings, int robots, const std::string& lab,
                                        std::uint64_t seed) {
  hal::RandomStream clock(seed, lab + "/ode/clock");
  std::vector<RobotProfile> out(static_cast<std::size_t>(robots));
  for (std::size_t i = 0; i < out.size(); ++i) {
    RobotProfile& robot = out[i];
    hal::RandomStream chance(seed, lab + "/ode/motors", i);
    const double left = chance.normal(), right = chance.normal();
    robot.duties = {to_duty(70 + settings.duty_spread * left), to_duty(70 + settings.duty_spread * right),
                    to_duty(65 + settings.duty_spread * left), to_duty(65 + settings.duty_spread * right)};
    // in single precision, as the published runs were
    const auto bias_left = static_cast<float>(settings.speed_spread * chance.normal());
    const auto bias_right = static_cast<float>(settings.speed_spread * chance.normal());
    robot.straight_left_m_s = robot.pivot_left_m_s = bias_left * settings.speed_m_s;
    robot.straight_right_m_s = robot.pivot_right_m_s = bias_right * settings.speed_m_s;
    robot.turn_noise_rad_s = settings.turn_noise_deg_per_s * one_degree;
    robot.turn_noise_s = settings.turn_noise_s;
    robot.dead_duty = settings.dead_duty;
    robot.start_duty = settings.start_duty;
    robot.clock_slow = clock.uniform(-settings.clock_spread, settings.clock_spread);
    robot.send_spread = settings.send_spread;
  }
  return out;
}

void read_profiles(const std::filesystem::path& file, const DriveSettings& settings,
                   std::vector<RobotProfile>& profiles, std::span<const std::int64_t> ids) {
  const hal::Config config = hal::Config::from_file(file);
  const auto said = config.root().read<RobotsFile>();
  config.refuse_unknown();
  std::map<int, std::string> places;
  for (std::size_t k = 0; k < said.robots.size(); ++k) {
    const int id = said.robots[k].id;
    const hal::Section table = config.root().section("robot", static_cast<int>(k));
    const auto place = std::ranges::lower_bound(ids, id);
    const auto number = static_cast<std::size_t>(ids.empty() ? id : place - ids.begin());
    if (number >= profiles.size() || (!ids.empty() && *place != id))
      table.refuse("id", profiles.empty() ? "there are no robots in the arena"
                         : ids.empty()    ? fmt::format("the arena's robots are 0 to {}", profiles.size() - 1)
                                          : "is not one of the arena's robots; arena.ode.ids lists their ids");
    const auto [first, is_new] = places.emplace(id, table.place("id"));
    if (!is_new)
      table.refuse("id", fmt::format("robot {} has a table at {} already; use one table for each", id, first->second));
    said.robots[k].lay_over(settings, profiles[number]);
  }
}

}  // namespace arkmesh::sim_ode
