// The programs, scripts and other files that come with arkmesh.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace arkmesh::hal {

// Where the program of this process lies, and the others of arkmesh.
std::filesystem::path program_folder();

// `installed` in share/arkmesh of an installed program, or else `source` among the sources.
std::filesystem::path own_file(const std::filesystem::path& installed, const std::filesystem::path& source);

// Runs scripts/NAME, which is Python's, for half an hour at most, and returns the last line that it said. Throws
// std::runtime_error with that line when it failed.
std::string run_script(const std::string& name, std::vector<std::string> arguments);

// Runs it for as long as it takes, which says itself on the standard error how far it is and why it fails; Ctrl-C
// reaches it. Returns what it printed, at most 64 KiB. Throws std::runtime_error.
std::string watch_script(const std::string& name, std::vector<std::string> arguments);

}  // namespace arkmesh::hal
