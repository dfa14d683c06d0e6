// The programs, scripts and other files that come with arkmesh.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace arkmesh::hal {

// The file of this process's program. Empty when the system does not tell.
std::filesystem::path this_program();

// Where the programs of arkmesh lie: the folder of this process's program, or else the one of use_programs_in().
std::filesystem::path program_folder();

// For a program of somebody's own, which lies elsewhere: the folder of the arkmesh that it was built against. To be
// called before anything else, by one thread.
void use_programs_in(std::filesystem::path folder);

// `installed` in share/arkmesh of an installed program, or else `source` among the sources.
std::filesystem::path own_file(const std::filesystem::path& installed, const std::filesystem::path& source);

// Runs scripts/NAME, which is Python's, for half an hour at most, and returns the last line that it said. Throws
// std::runtime_error with that line when it failed.
std::string run_script(const std::string& name, std::vector<std::string> arguments);

// Runs it for as long as it takes, which says itself on the standard error how far it is and why it fails; Ctrl-C
// reaches it. Returns what it printed, at most 64 KiB. Throws std::runtime_error.
std::string watch_script(const std::string& name, std::vector<std::string> arguments);

}  // namespace arkmesh::hal
