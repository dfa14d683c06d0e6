#include "cli/swarm_command.hpp"

#include "cli/program.hpp"
#include "hal/platforms/kilobot/body.hpp"
#include "sim_ode/host/programs/controller_build.hpp"

namespace arkmesh::cli {

CLI::Option* ProgramOptions::add_to(CLI::App& command) {
  CLI::Option* const files =
      command
          .add_option("PROGRAM", paths,
                      "The C file for kilolib; or several files, or a folder of them, that form one program")
          ->required()
          ->check(CLI::ExistingPath);
  command.add_option("-I,--include", include, "A folder with headers, in addition to the program's own")
      ->allow_extra_args(false)
      ->check(CLI::ExistingDirectory);
  command.add_option("-D,--define", define, "Define a macro: -D NAME or -D NAME=VALUE")->allow_extra_args(false);
  return files;
}

sim_ode::ProgramSources ProgramOptions::sources() const {
  sim_ode::ProgramSources out;
  out.paths.assign(paths.begin(), paths.end());
  out.include.assign(include.begin(), include.end());
  out.define = define;
  for (const std::string& macro : define)
    if (const std::string wrong = sim_ode::wrong_with_macro(macro); !wrong.empty())
      throw CLI::ValidationError("--define", wrong);
  return out;
}

CLI::Option* SwarmCommand::add_to(CLI::App& command) {
  program.add_to(command);
  command.add_option("--robots", swarm.robots, "How many robots")->check(CLI::Range(1, 100000))->capture_default_str();
  CLI::Option* const time =
      command.add_option("--seconds", seconds, "Simulated time")->check(CLI::Range(0.1, 1e6))->capture_default_str();
  command.add_option("--arena", arena, "Width x height in metres")->capture_default_str();
  command.add_option("--light", light, "A lamp at x,y, metres from the arena's centre");
  command.add_option("--spacing", swarm.spacing_m, "Start on a square grid with this spacing in metres, not at random")
      ->check(CLI::Range(2 * hal::kilobot::body_radius_m, 10.0));
  command.add_option("--seed", swarm.seed, "Seed of all random numbers")->capture_default_str();
  command.add_option("--set", swarm.settings,
                     "Set a key of the arena: ode.preset=measured, ode.robots_file=robots.toml");
  return time;
}

void SwarmCommand::complete() {
  const auto sides = two_numbers(arena, 'x');
  if (!sides) throw CLI::ValidationError("--arena", "write width x height in metres, such as 1x1 or 0.5x2");
  swarm.width_m = sides->first;
  swarm.height_m = sides->second;
  if (!light.empty()) {
    const auto place = two_numbers(light, ',');
    if (!place) throw CLI::ValidationError("--light", "write x,y in metres from the arena's centre, such as 0.3,-0.2");
    swarm.light = hal::Pose{.x_m = place->first, .y_m = place->second};
  }
  swarm.program = program.sources();
  swarm.robots_folder = "robots";
}

}  // namespace arkmesh::cli
