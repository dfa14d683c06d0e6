// The simulated arena: robots with real contacts, run by unmodified Kilobot C programs, reached through an overhead
// controller's airtime. Seeded and bit-repeatable.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/arenas/arena_row.hpp"
#include "hal/config/config.hpp"
#include "sim_ode/host/programs/program_sources.hpp"
#include "sim_ode/host/robot_output.hpp"

namespace arkmesh::sim_ode {

// Reads the common [arena] keys and [arena.ode]. `seed` and `lab` name its random streams ("<lab>/ode/...").
// With arena.pace = 1 it keeps real time and cannot wait. Compiles the controller (arena.ode.controller, a kilolib C
// file); throws ConfigError with the compiler's first error when that fails. A program that compiles, but does not
// begin on a robot, is a ConfigError, too, unless somebody listens to what robots print: then it is a ProgramError.
std::unique_ptr<hal::Arena> make_ode_arena(const hal::Section& arena, const std::string& lab, std::uint64_t seed,
                                           const RobotOutput& output = {});
hal::ArenaRow ode_arena_row();
// The robots' program. Throws ConfigError.
ProgramSources program_of(const hal::Section& arena);
// The C files of the robots' program. Throws ConfigError.
std::vector<std::filesystem::path> program_files(const hal::Section& arena);

}  // namespace arkmesh::sim_ode
