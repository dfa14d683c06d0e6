// `arkmesh`: help, what needs neither arena nor camera, and the way to the programs beside it.
#include "cli/commands.hpp"
#include "cli/program.hpp"

int main(int argc, char** argv) {
  using namespace arkmesh::cli;
  static constexpr OwnCommand own[] = {{"doctor", [](CLI::App& app) { add_doctor_command(app, nullptr); }},
                                       {"up", add_up_command},
                                       {"status", add_status_command},
                                       {"ohc", add_ohc_command}};
  return arkmesh::cli::main(argc, argv, own);
}
