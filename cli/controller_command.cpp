// `arkmesh controller`: a robot's program by itself. `check` builds it for the robot; `run` has a file of its own.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "sim_ode/host/controller_check.hpp"

namespace arkmesh::cli {
namespace {

int check_controller(const std::filesystem::path& program) {
  const sim_ode::CheckedProgram checked = sim_ode::check_program(program);
  for (const std::string& warning : checked.warnings) fmt::print("{}\n", warning);
  fmt::print(
      "{}: flash {} of {} bytes (the library's {} included), static RAM {} of {} (the library's {} included; {} remain "
      "for the stack)\n",
      program.filename().string(), checked.flash_bytes, sim_ode::flash_limit_bytes, sim_ode::flash_library_bytes,
      checked.ram_bytes, sim_ode::ram_limit_bytes, sim_ode::ram_library_bytes,
      std::max(0, sim_ode::ram_limit_bytes - checked.ram_bytes));
  if (checked.fits()) return 0;
  fmt::print(stderr, "arkmesh: {} does not fit on a robot\n", program.filename().string());
  return 1;
}

}  // namespace

void add_controller_command(CLI::App& app) {
  auto* controller = add_command(app, "controller");
  controller->require_subcommand(1);
  controller->footer("Example:\n  arkmesh controller run my_robot.c --robots 25 --seconds 60 --png end.png");

  add_controller_run_command(*controller);

  auto* check =
      controller->add_subcommand("check", "Builds a Kilobot C program for the robot and says whether it fits");
  const auto program = std::make_shared<std::string>();
  check->add_option("PROGRAM", *program, "A C file for kilolib")->required()->check(CLI::ExistingFile);
  check->footer(
      "Example:\n  arkmesh controller check my_robot.c\nNeeds avr-gcc. Ends with 1 when the program does not build or "
      "does not fit.");
  check->callback([program] {
    if (const int code = check_controller(*program)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
