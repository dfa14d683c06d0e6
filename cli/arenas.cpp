#include "cli/arenas.hpp"

#include <functional>
#include <string>
#include <vector>

#include "hal/log_arena.hpp"
#include "hal/null_arena.hpp"
#include "sim_ode/ode_arena.hpp"

namespace arkmesh::cli {
namespace {

struct Entry {
  std::string name;
  std::function<std::unique_ptr<hal::Arena>(const hal::Section& arena, const scenarios::RunConfig& run)> make;
};

const std::vector<Entry>& arenas() {
  static const std::vector<Entry> table = {
      {"ode", [](auto& arena, auto& run) { return sim_ode::make_ode_arena(arena, run.lab, run.seed); }},
      {"replay", [](auto& arena, auto& run) { return hal::make_log_arena(arena, run.lab, run.period * run.last_period); }},
      {"null", [](auto& arena, auto& run) { return hal::make_null_arena(arena, run.lab); }},
  };
  return table;
}

}  // namespace

std::unique_ptr<hal::Arena> make_arena(const hal::Section& root, const scenarios::RunConfig& run) {
  const hal::Section arena = root.section("arena");
  std::vector<std::string> names;
  for (const Entry& entry : arenas()) names.push_back(entry.name);
  const std::string use = arena.choice("use", "ode", names);
  // The keys of arenas that are not in use stay in the file, so that one key swaps them.
  for (const std::string& name : names)
    if (name != use) arena.leave_alone(name);
  for (const Entry& entry : arenas())
    if (entry.name == use) return entry.make(arena, run);
  arena.refuse("use", "names no arena");
}

}  // namespace arkmesh::cli
