#include "app/testbed/set_up.hpp"

#include "app/arenas.hpp"
#include "hal/config/config.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::app {

testbed::SetUpArena make_set_up_arena(const std::string& file, const std::vector<std::string>& sets,
                                      const std::string& program, hal::StopRequest& stop) {
  using Robots = hal::ArenaRow::Robots;
  const hal::Config config = hal::Config::from_file(file, sets);
  const hal::Section arena = config.root().section("arena");
  const auto run = config.root().read<lab::RunConfig>();
  const hal::ArenaRow& row = chosen_arena(arena);
  if (row.robots == Robots::none)
    arena.refuse("use", "has no robots to talk to; use \"kilobot\", \"emulated\" or \"ode\"");
  const hal::ArenaRequest request{.lab = run.lab, .seed = run.seed, .set_up = true, .program = program};
  return testbed::SetUpArena(row.make(arena, request), row.robots == Robots::simulated, run.seed, stop);
}

}  // namespace arkmesh::app
