// Robots' programs that an installation has already built: where there is no compiler, the shipped experiments run all
// the same. An object's name is the hash of all that we and the program's files say, wherever they lie.
#pragma once

#include <filesystem>
#include <optional>

#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::sim_ode {

// Of an installed arkmesh: lib/arkmesh/programs beside its bin.
std::filesystem::path shipped_programs_folder();
// The object of this program in `folder`; nothing when it is not there. To be copied: several may load it.
std::optional<std::filesystem::path> find_shipped(const ReadProgram& program, const std::filesystem::path& folder);
// Compiles the program into `folder`, which is made when it is not there. Throws ProgramError.
void ship_program(const ReadProgram& program, const std::filesystem::path& folder);

}  // namespace arkmesh::sim_ode
