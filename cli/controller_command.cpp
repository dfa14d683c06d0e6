// `arkmesh controller`: a robot's program by itself. `check` and `build` build it for the robot; `run` has a file of
// its own.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "sim_ode/host/controller_build.hpp"
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

int build_controller(const std::filesystem::path& program, const std::filesystem::path& kilolib,
                     const std::filesystem::path& hex) {
  sim_ode::BuiltProgram built;
  try {
    built = sim_ode::build_program(program, kilolib, hex);
  } catch (const sim_ode::BuildError& error) {
    fmt::print(stderr, "{}arkmesh: {}\n", error.said, error.what());
    return 1;
  }
  fmt::print(stderr, "{}", built.said);
  const auto& [flash, ram] = built.sizes;
  fmt::print("{}: flash {} of {} bytes, static RAM {} of {} ({} remain for the stack)\n", program.filename().string(),
             flash, sim_ode::flash_limit_bytes, ram, sim_ode::ram_limit_bytes,
             std::max(0, sim_ode::ram_limit_bytes - ram));
  if (built.pages == 0) {
    fmt::print(stderr, "arkmesh: {} does not fit on a robot; {} is not written\n", program.filename().string(),
               hex.string());
    return 1;
  }
  fmt::print("{}: {} pages; load it with `arkmesh ohc PORT upload {}`\n", hex.string(), built.pages, hex.string());
  return 0;
}

void add_build_command(CLI::App& controller) {
  struct Options {
    std::string program, kilolib, hex;
  };
  const auto options = std::make_shared<Options>();
  auto* build =
      controller.add_subcommand("build", "Builds a Kilobot C program into the file that robots are loaded with");
  build->add_option("PROGRAM", options->program, "A C file for kilolib")->required()->check(CLI::ExistingFile);
  build->add_option("-o,--output", options->hex, "The Intel HEX file; default: PROGRAM's name, in this folder");
  build
      ->add_option("--kilolib", options->kilolib,
                   "The robot's library: a folder with kilolib.h and kilolib.c, or kilolib.a")
      ->required();
  build->footer(
      "Example:\n  git clone https://github.com/acornejo/kilolib\n"
      "  arkmesh controller build my_robot.c -o my_robot.hex --kilolib kilolib\n"
      "  arkmesh ohc /dev/ttyUSB0 upload my_robot.hex\n"
      "Needs avr-gcc. Ends with 1 when the program does not build or does not fit, with 2 when there is no kilolib.");
  build->callback([options] {
    const std::filesystem::path program = options->program;
    const std::string hex = options->hex.empty() ? program.stem().string() + ".hex" : options->hex;
    if (const int code = build_controller(program, options->kilolib, hex)) throw CLI::RuntimeError(code);
  });
}

}  // namespace

void add_controller_command(CLI::App& app) {
  auto* controller = add_command(app, "controller");
  controller->require_subcommand(1);
  controller->footer("Example:\n  arkmesh controller run my_robot.c --robots 25 --seconds 60 --png end.png");

  add_controller_run_command(*controller);
  add_build_command(*controller);

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
