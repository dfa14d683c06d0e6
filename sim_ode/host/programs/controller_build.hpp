// Builds a robot's program for real robots: compiles and links it with a kilolib that the user has, and writes what
// `arkmesh ohc PORT upload` takes. Runs nothing.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim_ode/host/programs/avr_tools.hpp"
#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::sim_ode {

struct BuiltProgram {
  Sizes sizes;       // with the library
  int pages = 0;     // that an upload sends; 0: it does not fit, and no file was written
  std::string said;  // by the compiler: warnings
};

// The program does not build: what the compiler says, and a sentence.
struct BuildError : std::runtime_error {
  BuildError(const std::string& sentence, std::string output) : std::runtime_error(sentence), said(std::move(output)) {}
  std::string said;
};

// `kilolib`: a folder with kilolib.h and kilolib.c, message_*.c or message_*.S, or with kilolib.a; or that file. Throws
// hal::ConfigError when it is none, BuildError, or std::runtime_error with one sentence.
BuiltProgram build_program(const ProgramSources& sources, const std::filesystem::path& kilolib,
                           const std::filesystem::path& hex);

}  // namespace arkmesh::sim_ode
