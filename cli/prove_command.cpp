// `arkmesh controller prove`: a robot's program on a robot's processor.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "app/arenas.hpp"
#include "app/joint_run.hpp"
#include "app/recorded_run.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "cli/swarm_command.hpp"
#include "hal/counted.hpp"
#include "hal/files/scratch_folder.hpp"
#include "hal/record/result_file.hpp"
#include "sim_ode/controller_swarm.hpp"
#include "sim_ode/host/proof/proof.hpp"
#include "sim_ode/ode_arena.hpp"

namespace arkmesh::cli {
namespace {

struct ProveCommand : SwarmCommand {
  std::string run, lab;
  int robot = 0;  // its id
};

// Returns the exit code. `failure`: how the simulation ended early; empty: it did not.
int prove(const sim_ode::ProgramSources& program, const sim_ode::TurnLog& log, const std::string& failure,
          const std::string& robots) {
  const std::string name = program.name();
  const sim_ode::Proof proof = sim_ode::prove_program(program, log);
  for (const std::string& cause : proof.causes) fmt::print("{}: {}\n", name, cause);
  for (const std::string& note : proof.notes) fmt::print("{}: {}\n", name, note);
  for (const std::string& words : {proof.figures, proof.not_compared})
    if (!words.empty()) fmt::print("{}: {}\n", name, words);
  if (!failure.empty()) fmt::print("{}: here {}\n", name, failure);
  if (!proof.causes.empty()) {
    fmt::print("{}: behaves differently on a robot, {}\n", name, hal::counted(proof.causes.size(), "cause"));
    return 1;
  }
  fmt::print("{}: every output is the same on {}\n", name, robots);
  return failure.empty() ? 0 : 1;
}

int prove_on_swarm(const SwarmCommand& given) {
  sim_ode::TurnLog log(given.swarm.robots);
  sim_ode::SwarmOptions options = given.swarm;
  options.log = &log;
  std::string failure;
  sim_ode::ControllerSwarm swarm(options);
  try {
    swarm.run_until(hal::LabTime(static_cast<std::int64_t>(given.seconds * 1e6)), [](const hal::PoseFrame&) {});
  } catch (const std::runtime_error& error) {
    failure = error.what();
  }
  return prove(options.program, log, failure, hal::counted(options.robots, "robot"));
}

// Simulates a recorded run again, and proves the program of one robot with what that robot got.
int prove_in_run(const ProveCommand& given) {
  const app::RecordedRun recorded(given.run, std::nullopt);
  hand_over_cameras(recorded.config_files(), {});
  std::vector<hal::Config> configs = recorded.configs();
  std::vector<std::string> names;
  for (const hal::Config& config : configs)
    names.push_back(config.root().section("lab").get("name", std::string(), {.required = true}));
  const auto at = given.lab.empty() && names.size() == 1 ? names.begin() : std::ranges::find(names, given.lab);
  if (at == names.end())
    throw CLI::ValidationError("--lab", fmt::format("choose one of the run's labs: {}", fmt::join(names, ", ")));
  const std::string lab = *at;
  const hal::Section arena = configs[static_cast<std::size_t>(at - names.begin())].root().section("arena");
  if (app::chosen_arena(arena).name != "ode")
    throw hal::ConfigError(fmt::format("the inputs of lab {} cannot be reproduced: its arena.use is not \"ode\"", lab));
  sim_ode::TurnLog log(static_cast<int>(arena.get("robots", std::int64_t{0})));
  std::vector<hal::ArenaRow>& rows = app::arena_rows();
  *std::ranges::find(rows, "ode", &hal::ArenaRow::name) =
      sim_ode::ode_arena_row([&](const std::string& of) { return of == lab ? &log : nullptr; });

  for (const std::string& change : recorded.changes()) fmt::print(stderr, "arkmesh: {}\n", change);
  const hal::ScratchFolder scratch("prove");
  app::JointRun run(configs, scratch.path() / "run");
  const std::vector<hal::RobotId>& ids = run.lab(lab).arena().info().robots;
  const auto robot = std::ranges::find(ids, given.robot);
  if (robot == ids.end())
    throw CLI::ValidationError("--robot", fmt::format("lab {} has the robots {} to {}", lab, ids.front(), ids.back()));
  const auto index = static_cast<int>(robot - ids.begin());
  log.keep_only(index);
  OperatorStop stop;
  ProgressLine progress(run.names());
  const nlohmann::json result = run.run(stop, &progress);
  if (stop.stopped()) return exit_code(hal::Outcome::stopped);
  if (result.at("final_hash").get<std::string>() != recorded.final_hash())
    fmt::print(stderr,
               "arkmesh: the repeated run differs from the record; robot {} got the inputs of the repeated run\n",
               given.robot);
  return prove(sim_ode::program_of(arena, index), log, run.finished() ? "" : hal::ended_in(result),
               fmt::format("robot {} of lab {}", given.robot, lab));
}

}  // namespace

void add_prove_command(CLI::App& controller) {
  auto* command = controller.add_subcommand(
      "prove", "Run a Kilobot C program on an emulated robot processor, beside a simulated swarm");
  const auto options = std::make_shared<ProveCommand>();
  options->light = "0.3,0";
  options->add_to(*command);
  CLI::Option* const program = command->get_option("PROGRAM")->required(false);
  const std::vector<CLI::Option*> of_swarm = command->get_options();
  CLI::Option* const run = command
                               ->add_option("--run", options->run,
                                            "Use the inputs that a robot got in this recorded run of simulated robots")
                               ->check(CLI::ExistingPath);
  for (CLI::Option* option : of_swarm) run->excludes(option);
  command->add_option("--robot", options->robot, "That robot's id")->needs(run)->capture_default_str();
  command->add_option("--lab", options->lab, "Its lab, when the run has several")->needs(run);
  command
      ->add_flag("--hostile", options->swarm.hostile,
                 "Also send robots random messages, and altered copies of the swarm's")
      ->excludes(run);
  command->footer(
      "Examples:\n  arkmesh controller prove my_robot.c\n  arkmesh controller prove my_robot.c --hostile\n"
      "  arkmesh controller prove --run runs/demo --lab roark --robot 7\n"
      "Needs avr-gcc and simavr. Exit code 0 if every output is the same, 1 if one differs, 2 if the program cannot be "
      "tested.");
  command->callback([options, program, run] {
    if (run->count() == 0 && program->count() == 0) throw CLI::RequiredError("PROGRAM, or --run");
    if (run->count() == 0) options->complete();
    try {
      end_with(run->count() > 0 ? prove_in_run(*options) : prove_on_swarm(*options));
    } catch (const CLI::Error&) {
      throw;
    } catch (const std::runtime_error& error) {
      fmt::print(stderr, "arkmesh: {}: {}\n", run->count() > 0 ? options->run : options->swarm.program.name(),
                 error.what());
      end_with(2);
    }
  });
}

}  // namespace arkmesh::cli
