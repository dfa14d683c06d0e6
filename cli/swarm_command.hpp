// The options of commands that run one program on a simulated swarm.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "sim_ode/controller_swarm.hpp"
#include "sim_ode/host/programs/program_sources.hpp"

namespace arkmesh::cli {

// A program's files and options, as a user names them.
struct ProgramOptions {
  std::vector<std::string> paths, include, define;

  // Returns that of the files, which are required.
  CLI::Option* add_to(CLI::App& command);
  // Throws CLI::ValidationError.
  sim_ode::ProgramSources sources() const;
};

struct SwarmCommand {
  ProgramOptions program;
  sim_ode::SwarmOptions swarm;
  double seconds = 60;
  std::string arena = "1x1", light;

  // Returns that of the time.
  CLI::Option* add_to(CLI::App& command);
  // Reads what is still text. Throws CLI::ValidationError.
  void complete();
};

void add_prove_command(CLI::App& controller);

}  // namespace arkmesh::cli
