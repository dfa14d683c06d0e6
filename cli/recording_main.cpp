// `arkmesh-recording`: what is done with recorded runs. Knows neither arenas nor cameras.
#include "cli/commands.hpp"
#include "cli/program.hpp"

int main(int argc, char** argv) {
  using namespace arkmesh::cli;
  static constexpr OwnCommand own[] = {{"export", add_export_command}, {"plot", add_plot_command}};
  return arkmesh::cli::main(argc, argv, own);
}
