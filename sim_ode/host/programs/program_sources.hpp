// What a robots' program is made of: C files, and how they want to be compiled.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace arkmesh::sim_ode {

// The program cannot be read, does not compile, link or load: one sentence with the compiler's first error.
class ProgramError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// As a user names it.
struct ProgramSources {
  ProgramSources() = default;
  ProgramSources(std::filesystem::path path) : paths{std::move(path)} {}  // implicit: most programs are one file
  std::vector<std::filesystem::path> paths;    // C files, or folders, which stand for the C files in them
  std::vector<std::filesystem::path> include;  // folders with headers, beside the C files' own
  std::vector<std::string> define;             // macros, "NAME" or "NAME=VALUE"

  bool empty() const { return paths.empty(); }
  // For people: the name of the first path, also of "folder/" and ".".
  std::string name() const;
};

// The C files, those of a folder in the order of their names. Throws ProgramError: a folder without any, or a file
// twice. A path that is not there stays, to be refused by whoever reads it.
std::vector<std::filesystem::path> files_of(const ProgramSources& program);
// Of the same file in the same folder always the same, however it was named.
std::filesystem::path one_spelling(const std::filesystem::path& file);
// Why a macro cannot be defined so, as the end of a sentence; empty when it can.
std::string wrong_with_macro(const std::string& macro);

// What a file says. Throws ProgramError.
std::string read_source(const std::filesystem::path& file);

// Of a program's C files, which of them another one includes, and which so are compiled there. `read`: for each file
// what the compiler reads for it, itself perhaps included.
std::vector<bool> included_by_others(const std::vector<std::filesystem::path>& files,
                                     const std::vector<std::vector<std::string>>& read);

// As the compiler gets it.
struct ReadProgram {
  struct File {
    std::filesystem::path path;
    std::string text;
  };
  explicit ReadProgram(const ProgramSources& program);  // throws ProgramError
  // Where a file's headers are looked for: its own folder, those of `include`, those of the other files.
  std::vector<std::filesystem::path> folders_for(const std::filesystem::path& file) const;
  // What the robot's compiler is told of a file: where those headers are, and the macros.
  std::vector<std::string> options_for(const std::filesystem::path& file) const;
  bool says(std::string_view word) const;  // in any of its files

  std::vector<File> files;
  std::vector<std::filesystem::path> include;
  std::vector<std::string> define;
};

}  // namespace arkmesh::sim_ode
