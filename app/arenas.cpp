#include "app/arenas.hpp"

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "emulator/room_arena.hpp"
#include "hal/arena_config.hpp"
#include "hal/log_arena.hpp"
#include "hal/null_arena.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "sim_ode/ode_arena.hpp"
#include "testbed/table_window.hpp"

namespace arkmesh::app {
namespace {

// What an arena may need of the lab that it belongs to.
struct Around {
  const lab::RunConfig& run;
  hal::Bus& bus;
  const std::filesystem::path& directory;
};

struct Entry {
  std::string name;
  std::vector<std::string> tables;  // [arena.NAME]s that it reads
  std::function<std::unique_ptr<hal::Arena>(const hal::Section& arena, const Around& around)> make;
};

// Shows people what the cameras of a table see.
testbed::Onlooker window(const hal::Section& arena, const Around& around) {
  const auto window = std::make_shared<testbed::TableWindow>(
      arena.section("kilobot"), around.run.lab, hal::read_arena_config(arena, hal::kilobot::body_radius_m).frame_period,
      around.bus, around.directory);
  return [window](const testbed::Look& look) { window->look(look); };
}

const std::vector<Entry>& arenas() {
  static const std::vector<Entry> table = {
      {"ode", {"ode"}, [](auto& arena, auto& a) { return sim_ode::make_ode_arena(arena, a.run.lab, a.run.seed); }},
      {"kilobot",
       {"kilobot"},
       [](auto& arena, auto& a) {
         return hal::kilobot::make_kilobot_arena(arena, a.run.lab, testbed::make_table_watch(arena, window(arena, a)));
       }},
      {"room",
       {"room", "kilobot"},
       [](auto& arena, auto& a) { return emulator::make_room_arena(arena, a.run.lab, a.run.seed, window(arena, a)); }},
      {"replay",
       {"replay"},
       [](auto& arena, auto& a) {
         return hal::make_log_arena(arena, a.run.lab, hal::kilobot::model, a.run.period * a.run.last_period);
       }},
      {"null", {}, [](auto& arena, auto& a) { return hal::make_null_arena(arena, a.run.lab, hal::kilobot::model); }},
  };
  return table;
}

}  // namespace

std::unique_ptr<hal::Arena> make_arena(const hal::Section& root, const lab::RunConfig& run, hal::Bus& bus,
                                       const std::filesystem::path& directory) {
  const hal::Section arena = root.section("arena");
  std::vector<std::string> names;
  for (const Entry& entry : arenas()) names.push_back(entry.name);
  const std::string use = arena.choice("use", "ode", names);
  const auto chosen =
      std::find_if(arenas().begin(), arenas().end(), [&](const Entry& entry) { return entry.name == use; });
  if (chosen == arenas().end()) arena.refuse("use", "names no arena");
  // The keys of arenas that are not in use stay in the file, so that one key swaps them.
  for (const std::string& name : names)
    if (std::find(chosen->tables.begin(), chosen->tables.end(), name) == chosen->tables.end()) arena.leave_alone(name);
  return chosen->make(arena, {run, bus, directory});
}

}  // namespace arkmesh::app
