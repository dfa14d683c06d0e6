#include "hal/platforms/kilobot/arena_settings.hpp"

#include <utility>

#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/solids.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "hal/platforms/kilobot/robot_ids.hpp"

namespace arkmesh::hal::kilobot {

void ArenaSettings::fields(const Section& kilobot) {
  kilobot.field("port", port,
                {.help = "port of the overhead controller: a device or tcp://HOST:PORT",
                 .sample = "\"/dev/ttyUSB0\"",
                 .required = has_port});
  kilobot.field("ids", ids,
                {.help = "ids of the robots, such as [\"0-11\", \"40\"]", .default_is = "0 to arena.robots - 1"});
  kilobot.field("names_within_s", names_within, {{1, 3600}, "s", "time limit for finding all robots at the start"});
  kilobot.field("may_miss", may_miss, {{0, 1023}, "robots", "how many robots may still be missing then"});
  overhead.fields(kilobot);
}

ArenaSettings read_arena_settings(const Section& arena, const std::string& lab, bool has_port) {
  const ArenaConfig config = read_arena_config(arena, body_radius_m);
  const WordLayout layout = read_layout(arena);
  ArenaSettings out = arena.section("kilobot").read(
      ArenaSettings{.info = ArenaInfo{kind_of(layout, WholeMessages::to_everyone)}, .has_port = has_port});
  if (!has_port) out.port.clear();
  Solids solids = read_solids(arena);
  if (!solids.objects.empty())
    arena.refuse("objects", "cameras do not see objects; remove them, or use a simulated arena");
  out.info.obstacles = std::move(solids.obstacles);
  out.info.name = lab;
  out.info.platform = "kilobot";
  out.info.width_m = config.width_m;
  out.info.height_m = config.height_m;
  out.info.robots = read_robot_ids(arena, layout);
  out.info.can_wait = false;
  out.info.frame_period = config.frame_period;
  return out;
}

}  // namespace arkmesh::hal::kilobot
