// The scripts in Python that draw for commands, and come with the program.
#pragma once

#include <string>
#include <vector>

namespace arkmesh::cli {

// Runs scripts/NAME with these arguments, for half an hour at most, and returns the last line that it said. Throws
// std::runtime_error with that line when it failed.
std::string run_drawing_script(const std::string& name, const std::vector<std::string>& arguments);

// Runs it for as long as it takes, which says itself on the standard error how far it is and why it fails; Ctrl-C
// reaches it. Returns what it printed.
std::string watch_drawing_script(const std::string& name, const std::vector<std::string>& arguments);

}  // namespace arkmesh::cli
