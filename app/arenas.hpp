// The only place where concrete arenas are named: one line each.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/arenas/arena_row.hpp"
#include "hal/bus/bus.hpp"
#include "hal/config/config.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::app {

// Of [arena]; what each arena reads besides is its own.
struct ArenaUse {
  std::string use = "ode";

  void fields(const hal::Section& arena);
};

// All arenas that this program was built with. A program of your own may add its own before it makes labs.
std::vector<hal::ArenaRow>& arena_rows();

// The row that arena.use names. Keys of arenas that are not in use stay in the file, so that one key swaps them. Throws
// ConfigError.
const hal::ArenaRow& chosen_arena(const hal::Section& arena);
// Words to single robots that it has airtime for in a second; none: it says nothing of its airtime.
std::optional<double> words_per_s(const hal::Section& arena);

// The files of what simulated robots run there; none where robots are real, or not there. Throws ConfigError.
std::vector<std::filesystem::path> robots_programs_of(const hal::Section& arena);

// The arena of a lab's run. An arena with cameras shows their pictures on `pictures` and keeps videos in
// `directory`, with what it hears on `bus` drawn over them; bus and board outlive the arena. Refuses what
// nobody has read of the configuration. Throws ConfigError.
std::unique_ptr<hal::Arena> make_arena(const hal::Config& config, const lab::RunConfig& run, hal::Bus& bus,
                                       hal::PictureBoard& pictures, const std::filesystem::path& directory);

}  // namespace arkmesh::app
