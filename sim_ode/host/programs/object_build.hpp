// Makes a shared object of a Kilobot C program and our library, with the C compiler `cc`. Keeps nothing.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "sim_ode/host/programs/compiler_limits.hpp"
#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::sim_ode {

// Where kilolib.h and the rest of what programs are compiled against lie: beside the sources, or beside an installed
// arkmesh. Throws ProgramError.
std::filesystem::path kilolib_folder();
// Likewise arkmesh_id.h and the programs of the set-up procedures, which real robots run as simulated ones do.
std::filesystem::path firmware_folder();
// What to do about a function or header that a compiler misses, and that is near the program; else empty.
std::string lies_elsewhere(const ReadProgram& program, const std::string& sentence);

class ObjectBuild {
 public:
  // `work` is an empty folder; the program outlives the build. Throws ProgramError.
  ObjectBuild(const ReadProgram& program, const std::filesystem::path& work, CompilerLimits limits = {});

  // Makes the object. Throws ProgramError with the compiler's first error.
  void run();

  // All that decides the object: what the compiler is told, the program preprocessed, and what the files say that it
  // has read for that. Empty when it depends on the moment, or cannot be preprocessed.
  std::vector<std::string> decided_by();
  // In `work`.
  const std::filesystem::path& object() const { return object_; }

 private:
  struct Part {
    std::filesystem::path source;  // the user's file
    // in a folder of its own: a quoted include then finds our headers before old ones beside the program
    std::filesystem::path copy;
    std::filesystem::path expanded, typed;  // the same, preprocessed; and with a robot's types
    std::filesystem::path object;
  };
  void compile(const std::filesystem::path& source, const std::vector<std::string>& more) const;
  void build(const std::vector<std::string>& options) const;
  void expand();
  std::string with_own_names(std::string output) const;

  const ReadProgram& program_;
  const std::filesystem::path work_, kilolib_, firmware_;
  std::vector<Part> parts_;
  const std::filesystem::path object_;
  const std::chrono::steady_clock::time_point deadline_;
  const CompilerLimits limits_;
  bool is_expanded_ = false;  // as run() begins
  bool plain_clock_ = false, more_headers_ = false, waits_for_memory_ = false;
  std::string pc_types_option_;  // empty: a robot's types
};

}  // namespace arkmesh::sim_ode
