// A robot's types in a program for a PC: int has 16 bits, long has 32, double is float. Rewrites what the preprocessor
// made of a C file, in the program's own lines only: the system's headers and ours keep a PC's types.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace arkmesh::sim_ode {

// Whether the program's own lines follow a line marker of expanded C text, `# 17 "/usr/include/stdio.h" 1 3 4`; lines
// of files in `ours` are none.
bool program_follows(std::string_view marker, const std::filesystem::path& ours);

// Types and constants. An expression still calculates with 32 bits, as a PC does.
std::string with_robot_types(const std::string& expanded, const std::filesystem::path& ours);

}  // namespace arkmesh::sim_ode
