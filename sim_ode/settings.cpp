// One line per key, ranges included.
#include "sim_ode/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <numbers>
#include <span>
#include <utility>

namespace arkmesh::sim_ode {
namespace {

// Keys of vibration motors, infrared between robots, and Kilobots' batteries, where they are not as `own` has them.
const char* kilobots_only(const Settings& given, const Settings& own) {
  const std::pair<const char*, bool> keys[] = {
      {"preset", given.preset != own.preset},
      {"robots_file", given.robots_file != own.robots_file},
      {"speed_m_per_s", given.speed_m_s != own.speed_m_s},
      {"turn_deg_per_s", given.turn_deg_per_s != own.turn_deg_per_s},
      {"speed_spread", given.speed_spread != own.speed_spread},
      {"duty_spread", given.duty_spread != own.duty_spread},
      {"dead_duty", given.dead_duty != own.dead_duty},
      {"start_duty", given.start_duty != own.start_duty},
      {"battery_mah", given.battery_mah != own.battery_mah},
      {"battery_idle_ma", given.battery_idle_ma != own.battery_idle_ma},
      {"battery_motor_ma", given.battery_motor_ma != own.battery_motor_ma},
      {"battery_led_ma", given.battery_led_ma != own.battery_led_ma},
      {"battery_empty_share", given.battery_empty_share != own.battery_empty_share},
      {"send_spread", given.send_spread != own.send_spread},
      {"infrared", given.infrared != own.infrared},
      {"ir_range_m", given.ir_range_m != own.ir_range_m},
      {"ir_range_spread_m", given.ir_range_spread_m != own.ir_range_spread_m},
      {"ir_loss", given.ir_loss != own.ir_loss},
      {"ir_noise_m", given.ir_noise_m != own.ir_noise_m},
      {"ir_noise_per_m", given.air.ir_noise_per_m != own.air.ir_noise_per_m},
      {"ir_flat_m", given.air.ir_flat_m != own.air.ir_flat_m},
      {"ir_reading_spread", given.air.ir_reading_spread != own.air.ir_reading_spread},
      {"overhead_distance_m", given.air.overhead_distance_m != own.air.overhead_distance_m},
  };
  const auto wrong = std::ranges::find_if(keys, [](const auto& key) { return key.second; });
  return wrong == std::end(keys) ? nullptr : wrong->first;
}

void fields_of_program(const hal::Section& s, ProgramSources& program, int& loops_per_tick,
                       std::vector<std::int64_t>& ids) {
  s.field("include", program.include, {.help = "further header folders of that program"});
  s.field("define", program.define, {.help = "macros for that program, \"NAME\" or \"NAME=VALUE\""});
  s.field("loops_per_tick", loops_per_tick,
          {.range = {1, 100'000}, .help = "calls of loop per tick (on a robot, thousands)"});
  s.field("ids", ids, {{0, 65'535}, "", "robots' ids (kilo_uid), ascending; a single one is the first robot's"});
}

void check_program(const hal::Section& s, const ProgramSources& program, const std::vector<std::int64_t>& ids) {
  if (std::ranges::adjacent_find(ids, std::greater_equal()) != ids.end())
    s.refuse("ids", "must be ascending, each id once");
  for (const std::string& macro : program.define)
    if (const std::string wrong = wrong_with_macro(macro); !wrong.empty()) s.refuse("define", wrong);
}

}  // namespace

void StartSettings::fields(const hal::Section& ode) {
  ode.field("start", start,
            {.help = "region of random starts: anywhere, within 0.8 of the sides, or as start_at says",
             .one_of = {"uniform", "centre80", "box", "disc", "ring", "grid"}});
  ode.field("start_at", start_at,
            {{-100, 100}, "m", "x, y of a centre, then: box width, height; disc radius; ring radii; grid spacing"});
  ode.field("start_poses", start_numbers_,
            {{-100, 100}, "m, rad", "x, y, heading of each robot in order; overrides start"});
}

void StartSettings::check(const hal::Section& ode) {
  const std::vector<double>& poses = start_numbers_;
  if (poses.size() % 3 != 0)
    ode.refuse("start_poses", "must hold three numbers for each robot: x, y in metres, heading in radians");
  for (std::size_t i = 0; i < poses.size(); i += 3) start_poses.push_back({poses[i], poses[i + 1], poses[i + 2]});
  static constexpr const char* meant[] = {"",
                                          "",
                                          "x, y, width, height of the box",
                                          "x, y, radius of the disc",
                                          "x, y, inner and outer radius of the ring",
                                          "x, y, spacing of the grid"};
  static constexpr std::size_t numbers[] = {0, 0, 4, 3, 4, 3};
  const auto form = static_cast<std::size_t>(start);
  if (numbers[form] == 0 && !start_at.empty())
    ode.refuse("start_at", "belongs to start = \"box\", \"disc\", \"ring\" or \"grid\"; remove it");
  if (start_at.size() != numbers[form] ||
      std::ranges::any_of(std::span(start_at).subspan(std::min<std::size_t>(2, start_at.size())),
                          [](double m) { return m < 0; }) ||
      (start == Start::ring && start_at[2] > start_at[3]))
    ode.refuse("start_at", fmt::format("must hold {}; lengths are 0 or more, and ascend", meant[form]));
}

void GroupSettings::fields(const hal::Section& group) {
  group.field("robots", robots, {{1, 100'000}, "", "number of robots in the group"});
  group.field("controller", controller.paths, {.help = "C file of the group's program; empty: that of [arena.ode]"});
  fields_of_program(group, controller, loops_per_tick, ids);
  StartSettings::fields(group);
}

void GroupSettings::check(const hal::Section& group) {
  check_program(group, controller, ids);
  StartSettings::check(group);
}

void PresetKey::fields(const hal::Section& ode) {
  ode.field("preset", preset,
            {.help = "defaults of the other keys: ideal robots, or values reported of real ones",
             .one_of = {"ideal", "measured", "measured_0"}});
}

void RobotKey::fields(const hal::Section& ode) {
  ode.field("robot", robot,
            {.help = "make of the robots; Thymios have wheels and start with their own program",
             .one_of = {"kilobot", "thymio"}});
}

void Settings::fields(const hal::Section& ode) {
  PresetKey::fields(ode);
  RobotKey::fields(ode);
  ode.field("controller", controller.paths,
            {.help = "C file of the robots' program; a list or a folder for a program of several files",
             .sample = "\"arkmesh:scenarios/dhtf/controller/dhtf.c\"",
             .required = controller.empty() && ode.place("group").empty()});
  fields_of_program(ode, controller, loops_per_tick, ids);
  ode.field("robots_file", robots_file, {.help = "file with properties of individual robots"});
  enum class OnFault { end, leave } on_fault = leave_failed ? OnFault::leave : OnFault::end;
  ode.field("on_fault", on_fault,
            {.help = "when a robot's program crashes or hangs: end the run, or stop only that robot",
             .one_of = {"end", "leave"}});
  leave_failed = on_fault == OnFault::leave;
  StartSettings::fields(ode);
  ode.field("group", groups);
  ode.field(
      "solver", contacts.solver,
      {.help = "contact solver: ODE, or arkmesh's faster one for clusters of robots only", .one_of = {"ode", "fast"}});
  ode.field("friction", contacts.friction, {{0, 10}, "", "friction coefficient between bodies and with walls"});
  ode.field("speed_m_per_s", speed_m_s, {{0, 0.1}, "m/s", "speed with both motors at their calibrated duty"});
  ode.field("turn_deg_per_s", turn_deg_per_s, {{0, 360}, "deg/s", "turn rate with one motor at its calibrated duty"});
  ode.field("speed_spread", speed_spread, {{0, 0.5}, "", "relative s.d. of the motors' speeds"});
  ode.field("duty_spread", duty_spread, {{0, 20}, "", "s.d. of the calibrated duties, of 255"});
  ode.field("motion_noise", motion_noise, {{0, 0.5}, "", "s.d. of a factor on speed and turn rate, drawn each tick"});
  ode.field("turn_noise_deg_per_s", turn_noise_deg_per_s,
            {{0, 90}, "deg/s", "s.d. of a slowly varying turn rate while a robot moves"});
  ode.field("turn_noise_s", turn_noise_s, {{0, 60}, "s", "correlation time of that turn rate"});
  ode.field("dead_duty", dead_duty, {{1, 255}, "", "a motor does not turn below this duty, of 255"});
  ode.field(
      "start_duty", start_duty,
      {{0, 255}, "", "a motor at rest starts at this duty; below it only after spinup_motors(); 0: at dead_duty"});
  BatterySettings::fields(ode);
  ode.field("lamp", lamp_numbers_, {{-100, 100}, "m", "positions of the lamps: x, y of each"});
  ode.field("light_noise", light_noise, {{0, 1023}, "", "largest error of a reading of ambient light, of 1023"});
  ode.field("clock_spread", clock_spread, {{0, 0.025}, "", "largest relative error of a robot's clock"});
  ode.field("send_spread", send_spread,
            {{0, 0.025}, "", "largest relative error of the interval between a robot's messages, drawn for each"});
  ode.field("composite_s", composite, {{0.005, 60}, "s", "time between two composites of the overhead controller"});
  ode.field("overhead_loss", overhead_loss, {{0, 1}, "", "probability that a robot misses a composite"});
  ode.field(
      "infrared", infrared,
      {.help = "message model: as on robots, or as in ARGoS's plug-in for Kilobots", .one_of = {"robot", "argos"}});
  ode.field("argos_tick_s", argos_tick, {{0.001, 1}, "s", "duration of an ARGoS tick: 1 / ticks_per_second"});
  ode.field("argos_ignore_conflicts", argos_ignore_conflicts,
            {.help = "ARGoS's ignore_conflicts: all robots that send in one tick succeed"});
  ode.field("ir_range_m", ir_range_m, {{0, 1}, "m", "infrared range"});
  ode.field("ir_loss", ir_loss, {{0, 1}, "", "probability that a message in range is not received"});
  ode.field("ir_range_spread_m", ir_range_spread_m, {{0, 0.2}, "m", "s.d. of the range between pairs of robots"});
  ode.field("ir_noise_m", ir_noise_m, {{0, 0.1}, "m", "s.d. of distance measurements"});
  air.fields(ode);
}

void Settings::check(const hal::Section& ode) {
  if (controller.empty() && groups.empty()) ode.refuse("controller", "is missing; name the C file that robots run");
  check_program(ode, controller, ids);
  if (robot != Robot::kilobot)
    if (const char* const key = kilobots_only(*this, settings_of(Preset::ideal, robot)))
      ode.refuse(key, "applies to Kilobots only, not to robot = \"thymio\"; remove it");
  if (infrared == InfraredRules::argos) {
    for (const char* key : {"send_spread", "overhead_distance_m", "ir_range_spread_m", "ir_noise_m", "ir_noise_per_m",
                            "ir_flat_m", "ir_reading_spread"})
      if (!ode.place(key).empty())
        ode.refuse(key, "applies to infrared = \"robot\" only; remove it, or infrared = \"argos\"");
  }
  StartSettings::check(ode);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const hal::Section keys = ode.section("group", static_cast<int>(i));
    ProgramSources& own = groups[i].controller;
    groups[i].table = static_cast<int>(i);
    if (own.empty()) own.paths = controller.paths;
    if (own.empty()) keys.refuse("controller", "is missing, here and in [arena.ode]; name the C file");
    own.include.insert(own.include.end(), controller.include.begin(), controller.include.end());
    own.define.insert(own.define.begin(), controller.define.begin(), controller.define.end());
  }
  if (robot == Robot::kilobot) contacts.speed_m_s = speed_m_s;
  turn_rad_s = turn_deg_per_s * std::numbers::pi / 180;
  const std::vector<double>& lamp = lamp_numbers_;
  if (lamp.size() % 2 != 0) ode.refuse("lamp", "must hold two numbers for each lamp: x, y in metres");
  for (std::size_t i = 0; i < lamp.size(); i += 2) lamps.push_back({lamp[i], lamp[i + 1], 0});
}

std::vector<RobotProfile> profiles_of(const Settings& settings, const hal::Section& ode, int robots,
                                      const std::string& lab, std::uint64_t seed) {
  std::vector<RobotProfile> out = draw_profiles(settings, robots, lab, seed);
  if (settings.robots_file.empty()) return out;
  if (!std::filesystem::exists(settings.robots_file)) ode.refuse("robots_file", "there is no such file");
  read_profiles(settings.robots_file, settings, out, settings.ids);
  return out;
}

Settings read_settings(const hal::Section& arena, const std::filesystem::path& program) {
  const hal::Section ode = arena.section("ode");
  Settings defaults = settings_of(ode.read<PresetKey>().preset, ode.read<RobotKey>().robot);
  if (!program.empty()) defaults.controller = program;
  Settings out = ode.read(std::move(defaults));
  if (!program.empty()) {  // also of include and define, and of all groups
    out.controller = program;
    for (GroupSettings& group : out.groups) group.controller = program;
  }
  out.blank_leds = arena.read<ViewSettings>().blank_leds;
  return out;
}

}  // namespace arkmesh::sim_ode
