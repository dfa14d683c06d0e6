// The `arkmesh` program: picks the subcommand, turns every failure into one sentence and an exit code.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "hal/config.hpp"

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app("Joins robot-swarm labs, real and simulated, into one shared world.");
  app.name("arkmesh");
  app.set_version_flag("--version", ARKMESH_VERSION);
  app.require_subcommand(1);
  app.footer("Exit codes: 0 done, 1 failed, 2 wrong command line or configuration.");
  arkmesh::cli::add_run_command(app);
  arkmesh::cli::add_lab_command(app);
  arkmesh::cli::add_gateway_command(app);
  arkmesh::cli::add_doctor_command(app);
  arkmesh::cli::add_controller_command(app);
  arkmesh::cli::add_room_command(app);
  arkmesh::cli::add_ohc_command(app);
  arkmesh::cli::add_track_command(app);
  arkmesh::cli::add_calibrate_command(app);
  arkmesh::cli::add_identify_command(app);
  arkmesh::cli::add_assign_ids_command(app);
  arkmesh::cli::add_calibrate_motors_command(app);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::RuntimeError& e) {
    return e.get_exit_code();
  } catch (const CLI::RequiredError& e) {
    // A command that there is not looks to CLI11 as if none had been given.
    const CLI::App* command = &app;
    std::string name = app.get_name();
    for (; !command->get_subcommands().empty(); command = command->get_subcommands().front())
      name += " " + command->get_subcommands().front()->get_name();
    const std::vector<std::string> rest = command->remaining();
    if (rest.empty() || command->get_require_subcommand_min() == 0) return app.exit(e) == 0 ? 0 : 2;
    fmt::print(stderr, "arkmesh: {} has no command {}; {} --help lists them\n", name, rest.front(), name);
    return 2;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const arkmesh::hal::ConfigError& e) {
    fmt::print(stderr, "arkmesh: {}\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    fmt::print(stderr, "arkmesh: {}\n", e.what());
    return 1;
  }
}
