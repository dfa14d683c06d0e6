#include "app/arenas.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "hal/arenas/log_arena.hpp"
#include "hal/arenas/null_arena.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "sim_ode/ode_arena.hpp"
#if ARKMESH_CAMERAS
#include "emulator/emulated_arena.hpp"
#include "testbed/aseba_row.hpp"
#include "testbed/kilobot_row.hpp"
#endif

namespace arkmesh::app {

std::vector<hal::ArenaRow>& arena_rows() {
  static std::vector<hal::ArenaRow> table = {
    sim_ode::ode_arena_row(),
#if ARKMESH_CAMERAS
    testbed::kilobot_arena_row(),
    testbed::aseba_arena_row(),
    emulator::emulated_arena_row(),
#else
    // Known by name, for whoever reads a lab's file without them.
    {"kilobot", {"kilobot"}, hal::ArenaRow::Robots::real, nullptr},
    {"aseba", {"aseba"}, hal::ArenaRow::Robots::real, nullptr},
    {"emulated", {"emulated", "kilobot"}, hal::ArenaRow::Robots::simulated, nullptr},
#endif
    hal::log_arena_row(),
    hal::null_arena_row(),
  };
  return table;
}

void ArenaUse::fields(const hal::Section& arena) {
  std::vector<std::string> names;
  for (const hal::ArenaRow& row : arena_rows()) names.push_back(row.name);
  arena.field("use", use, {.help = "kind of this lab's arena", .one_of = names});
}

// What of simulated robots would change an experiment, if real ones did not have it.
static void refuse_what_robots_cannot(const hal::Section& ode) {
  constexpr const char* no_ids =
      "apply to simulated robots only; real ones keep their ids (arkmesh assign-ids): remove this key";
  if (!ode.place("ids").empty()) ode.refuse("ids", no_ids);
  for (int i = 0; i < 100; ++i)
    if (!ode.section("group", i).place("ids").empty()) ode.section("group", i).refuse("ids", no_ids);
  if (!ode.place("infrared").empty() && ode.get("infrared", std::string()) != "robot")
    ode.refuse("infrared",
               "applies to simulated robots only; real ones follow a robot's rules: remove this key, or set it to "
               "\"robot\"");
}

const hal::ArenaRow& chosen_arena(const hal::Section& arena) {
  const std::vector<hal::ArenaRow>& rows = arena_rows();
  const auto use = arena.read<ArenaUse>().use;
  const auto chosen = std::ranges::find(rows, use, &hal::ArenaRow::name);
  if (!chosen->make) arena.refuse("use", "needs cameras, and this program was built without OpenCV");
  for (const hal::ArenaRow& row : rows)
    if (std::ranges::find(chosen->sections, row.name) == chosen->sections.end()) arena.leave_alone(row.name);
  // Emulated robots are spoken to like real ones.
  if (std::ranges::count(chosen->sections, "kilobot") > 0) refuse_what_robots_cannot(arena.section("ode"));
  return *chosen;
}

std::optional<double> words_per_s(const hal::Section& arena) {
  const hal::ArenaRow& row = chosen_arena(arena);
  if (!row.message_period) return std::nullopt;
  return 1e6 * hal::kilobot::groups / static_cast<double>(row.message_period(arena).count());
}

std::vector<std::filesystem::path> robots_programs_of(const hal::Section& arena) {
  const hal::ArenaRow& row = chosen_arena(arena);
  return row.inputs ? row.inputs(arena) : std::vector<std::filesystem::path>();
}

std::unique_ptr<hal::Arena> make_arena(const hal::Config& config, const lab::RunConfig& run, hal::Bus& bus,
                                       hal::PictureBoard& pictures, const std::filesystem::path& directory) {
  const hal::Section arena = config.root().section("arena");
  std::unique_ptr<hal::Arena> made = chosen_arena(arena).make(
      arena, {.robot = hal::kilobot::kind_of(hal::kilobot::read_layout(arena), hal::WholeMessages::to_each),
              .lab = run.lab,
              .seed = run.seed,
              .run_length = run.period * run.last_period,
              .bus = &bus,
              .pictures = &pictures,
              .directory = directory,
              .hung_after = std::chrono::duration_cast<std::chrono::milliseconds>(run.safety.hung_after),
              .all_read = [&] { config.refuse_unknown(); }});
  config.refuse_unknown();
  return made;
}

}  // namespace arkmesh::app
