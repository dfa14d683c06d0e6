#include "sim_ode/arena_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/counted.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "hal/random.hpp"
#include "hal/robot/thymio.hpp"
#include "sim_ode/host/programs/program_inputs.hpp"
#include "sim_ode/ode_arena.hpp"
#include "sim_ode/start_places.hpp"

namespace arkmesh::sim_ode {
namespace {

// The keys of a group, or of the robots that are in none.
hal::Section keys_for(const hal::Section& ode, const GroupSettings& group) {
  return group.table < 0 ? ode : ode.section("group", group.table);
}

// A single id is that of the first robot.
void count_on(std::vector<std::int64_t>& ids, int robots, const hal::Section& keys) {
  if (ids.size() == 1)
    while (static_cast<int>(ids.size()) < robots) ids.push_back(ids.back() + 1);
  if (static_cast<int>(ids.size()) != robots || (robots > 0 && ids.back() > 0xFFFF))
    keys.refuse("ids", fmt::format("must be {} ids up to 65535, or the first of them", robots));
}

}  // namespace

hal::RobotKind robots_of(Robot robot, const hal::kilobot::WordLayout& layout) {
  const hal::RobotKind by_layout = hal::kilobot::kind_of(layout, hal::WholeMessages::to_each);
  if (robot == Robot::kilobot) return by_layout;
  hal::RobotKind out = hal::thymio();
  out.max_robot = by_layout.max_robot;
  out.kinds = by_layout.kinds;
  out.values = std::min(out.values, by_layout.values);
  out.id_bits = by_layout.id_bits;
  out.kind_bits = by_layout.kind_bits;
  out.message_type = by_layout.message_type;
  return out;
}

hal::ArenaInfo info_of(const hal::ArenaConfig& config, const Settings& settings, const hal::kilobot::WordLayout& layout,
                       const hal::Solids& solids, const std::string& lab) {
  hal::ArenaInfo info{robots_of(settings.robot, layout)};
  info.name = lab;
  info.platform = settings.infrared == InfraredRules::argos ? "ode (infrared: argos)" : "ode";
  info.width_m = config.width_m;
  info.height_m = config.height_m;
  info.can_wait = config.pace == 0;
  info.obstacles = solids.obstacles;
  info.objects = solids.objects;
  info.frame_period = config.frame_period;
  info.robots.assign(settings.ids.begin(), settings.ids.end());
  for (int i = 0; info.robots.size() < static_cast<std::size_t>(config.robots); ++i)
    info.robots.push_back(static_cast<hal::RobotId>(i));
  return info;
}

void number_robots(const hal::Section& ode, Settings& settings, std::vector<GroupSettings>& groups,
                   std::vector<std::uint16_t>& named) {
  if (settings.ids.empty() && std::ranges::all_of(groups, [](const GroupSettings& g) { return g.ids.empty(); })) return;
  if (!named.empty()) ode.refuse("ids", "does not apply to emulated robots; arena.emulator.ids sets their ids");
  int common = 0;
  for (const GroupSettings& group : groups) common += group.ids.empty() ? group.robots : 0;
  if (settings.ids.empty() && common > 0) settings.ids = {0};
  count_on(settings.ids, common, ode);
  auto next = settings.ids.begin();
  for (GroupSettings& group : groups) {
    if (group.ids.empty())
      group.ids.assign(next, next + group.robots), next += group.robots;
    else
      count_on(group.ids, group.robots, keys_for(ode, group));
  }
  std::ranges::stable_sort(groups, {}, [](const GroupSettings& group) { return group.ids.front(); });
  std::vector<std::int64_t> all;
  for (const GroupSettings& group : groups) {
    if (!all.empty() && group.ids.front() <= all.back())
      keys_for(ode, group)
          .refuse("ids", fmt::format("begin with {}, and another group's end with {}; all of a group "
                                     "must be below or above all of another",
                                     group.ids.front(), all.back()));
    all.insert(all.end(), group.ids.begin(), group.ids.end());
  }
  named.assign(all.begin(), all.end());
  settings.ids = std::move(all);
}

std::vector<GroupSettings> groups_of(const hal::Section& ode, const Settings& settings, int robots) {
  std::vector<GroupSettings> out = settings.groups;
  int rest = robots;
  for (std::size_t i = 0; i < out.size(); ++i)
    if ((rest -= out[i].robots) < 0)
      ode.section("group", static_cast<int>(i))
          .refuse("robots", fmt::format("makes more than the arena's {}; use fewer, or raise arena.robots",
                                        hal::counted(robots, "robot")));
  if (rest == 0 && !out.empty()) {
    if (!settings.start_poses.empty())
      ode.refuse("start_poses", "places robots that are in no group, and there are none; remove it");
    return out;
  }
  if (settings.controller.empty())
    ode.refuse("controller", "is missing, but some robots are in no group; name their C file");
  out.push_back({settings, rest, settings.controller, settings.loops_per_tick, {}});
  return out;
}

std::vector<hal::Pose> start_of(const hal::ArenaConfig& config, const std::vector<GroupSettings>& groups,
                                const hal::Section& ode, const SolidBodies& furniture, const std::string& lab,
                                std::uint64_t seed) {
  const auto keys = [&](std::size_t i) { return keys_for(ode, groups[i]); };
  std::vector<hal::Pose> given;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const std::vector<hal::Pose>& poses = groups[i].start_poses;
    if (!poses.empty() && static_cast<int>(poses.size()) != groups[i].robots)
      keys(i).refuse("start_poses",
                     fmt::format("holds {} for {}; give each robot x, y, heading", hal::counted(poses.size(), "place"),
                                 hal::counted(groups[i].robots, "robot")));
    given.insert(given.end(), poses.begin(), poses.end());
  }
  StartPlaces places(config.width_m, config.height_m, furniture, given);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    hal::RandomStream chance(seed, lab + "/ode/start", static_cast<std::uint64_t>(groups[i].table + 1));
    if (!places.add(groups[i].robots, groups[i], chance))
      keys(i).refuse(groups[i].start_at.empty() ? "start" : "start_at",
                     fmt::format("has no room for {}; enlarge the region or the arena, or use fewer",
                                 hal::counted(groups[i].robots, "robot")));
    if (groups[i].start_poses.empty()) continue;
    if (const std::string error = error_with(places.poses(), config.width_m, config.height_m, furniture);
        !error.empty())
      keys(i).refuse("start_poses", error);
  }
  return places.poses();
}

ProgramSources program_of(const hal::Section& arena) {
  return read_settings(arena).controller;
}

ProgramSources program_of(const hal::Section& arena, int robot) {
  Settings settings = read_settings(arena);
  const hal::Section ode = arena.section("ode");
  std::vector<GroupSettings> groups =
      groups_of(ode, settings, hal::read_arena_config(arena, hal::kilobot::body_radius_m).robots);
  std::vector<std::uint16_t> ids;
  number_robots(ode, settings, groups, ids);
  auto group = groups.begin();
  for (; robot >= group->robots; ++group) robot -= group->robots;
  return group->controller;
}

std::vector<std::filesystem::path> program_files(const hal::Section& arena) {
  try {
    const Settings settings = read_settings(arena);
    std::vector<std::filesystem::path> out;
    const auto add = [&](const ProgramSources& program) {
      for (std::filesystem::path& file : files_with_headers(program))
        if (std::ranges::find(out, file) == out.end()) out.push_back(std::move(file));
    };
    if (!settings.controller.empty()) add(settings.controller);
    for (const GroupSettings& group : settings.groups) add(group.controller);
    return out;
  } catch (const ProgramError& error) {
    arena.section("ode").refuse("controller", error.what());
  }
}

}  // namespace arkmesh::sim_ode
