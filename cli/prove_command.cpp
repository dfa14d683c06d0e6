// `arkmesh controller prove`: a robot's program on a robot's processor.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/program.hpp"
#include "cli/swarm_command.hpp"
#include "hal/counted.hpp"
#include "sim_ode/controller_swarm.hpp"
#include "sim_ode/host/proof/proof.hpp"

namespace arkmesh::cli {
namespace {

// Returns the exit code.
int prove_controller(const SwarmCommand& given) {
  const std::string name = given.swarm.program.name();
  sim_ode::TurnLog log(given.swarm.robots);
  sim_ode::SwarmOptions options = given.swarm;
  options.log = &log;
  std::string failure;
  try {
    sim_ode::ControllerSwarm swarm(options);
    try {
      swarm.run_until(hal::LabTime(static_cast<std::int64_t>(given.seconds * 1e6)), [](const hal::PoseFrame&) {});
    } catch (const std::runtime_error& error) {
      failure = error.what();
    }
    const sim_ode::Proof proof = sim_ode::prove_program(options.program, log);
    for (const std::string& cause : proof.causes) fmt::print("{}: {}\n", name, cause);
    for (const std::string& note : proof.notes) fmt::print("{}: {}\n", name, note);
    for (const std::string& words : {proof.figures, proof.not_compared})
      if (!words.empty()) fmt::print("{}: {}\n", name, words);
    if (!failure.empty()) fmt::print("{}: here {}\n", name, failure);
    if (proof.causes.empty()) {
      fmt::print("{}: the same in every output on {}\n", name, hal::counted(options.robots, "robot"));
      return failure.empty() ? 0 : 1;
    }
    fmt::print("{}: different from what it does here, {}\n", name, hal::counted(proof.causes.size(), "cause"));
    return 1;
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "arkmesh: {}: {}\n", name, error.what());
    return 2;
  }
}

}  // namespace

void add_prove_command(CLI::App& controller) {
  auto* prove = controller.add_subcommand(
      "prove", "Run a Kilobot C program on an emulated robot processor, beside a simulated swarm");
  const auto options = std::make_shared<SwarmCommand>();
  options->light = "0.3,0";
  options->add_to(*prove);
  prove->footer(
      "Example:\n  arkmesh controller prove my_robot.c\nNeeds avr-gcc and simavr. Ends with 0 when every output is the "
      "same, with 1 when one is not, with 2 when it cannot be tried.");
  prove->callback([options] {
    options->complete();
    end_with(prove_controller(*options));
  });
}

}  // namespace arkmesh::cli
