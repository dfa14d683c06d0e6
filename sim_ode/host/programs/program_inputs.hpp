// Which files the compiler reads for a program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::sim_ode {

// The paths in rules as compilers write them for make, `a.o: a.c \` and so on.
std::vector<std::string> paths_in_rules(const std::string& rules);

// The names behind #include, #include_next and __has_include. A name that a macro makes is not seen.
std::vector<std::string> names_included(const std::string& text);

// A program's C files, and behind them the headers in its folders that they include, and those that these include.
// Throws as files_of() does.
std::vector<std::filesystem::path> files_with_headers(const ProgramSources& program);

// What a file says; empty when it cannot be read.
std::string content_of(const std::filesystem::path& file);

}  // namespace arkmesh::sim_ode
