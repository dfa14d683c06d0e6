// Which files decide what the compiler makes of a program: those that it read, and those that it would have read had
// they been there. Reads what is included only; knows nothing of caches.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::sim_ode {

// The paths in rules as compilers write them for make, `a.o: a.c \` and so on.
std::vector<std::string> paths_in_rules(const std::string& rules);

struct Included {
  std::string name;
  bool quoted;  // "name": looked for beside the includer first; else <name>
};
// The names behind #include, #include_next and __has_include. A name that a macro makes is not seen.
std::vector<Included> names_included(const std::string& text);

// Files that decide, there or not. `read` is what the compiler read, `folders` are where it looks for headers.
std::set<std::string> inputs_of(const std::vector<std::string>& read,
                                const std::vector<std::filesystem::path>& folders);

// A program's C files, and behind them the headers in its folders that they include, and those that these include.
// Throws as files_of() does.
std::vector<std::filesystem::path> files_with_headers(const ProgramSources& program);

// What a file says; empty when it cannot be read.
std::string content_of(const std::filesystem::path& file);

}  // namespace arkmesh::sim_ode
