// The simulated arena: robots with real contacts, run by unmodified Kilobot C programs, reached through an overhead
// controller's airtime. Seeded and bit-repeatable.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
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
// `hostile`: robots also receive what HostileAir makes.
std::unique_ptr<hal::Arena> make_ode_arena(const hal::Section& arena, const std::string& lab, std::uint64_t seed,
                                           const RobotOutput& output = {}, bool hostile = false);
// `log`: that of what happens to the robots' programs of a lab, which outlives the arena, or null.
hal::ArenaRow ode_arena_row(std::function<TurnLog*(const std::string& lab)> log = {});
// The robots' program. Throws ConfigError.
ProgramSources program_of(const hal::Section& arena);
// That of a robot, by its number in the arena.
ProgramSources program_of(const hal::Section& arena, int robot);
// The C files of the robots' program. Throws ConfigError.
std::vector<std::filesystem::path> program_files(const hal::Section& arena);

}  // namespace arkmesh::sim_ode
