// `arkmesh-lab`: labs with simulated arenas, and robots' programs by themselves. Knows no cameras.
#include "cli/commands.hpp"
#include "cli/program.hpp"

int main(int argc, char** argv) {
  using namespace arkmesh::cli;
  static constexpr OwnCommand own[] = {
    {"run", add_run_command},
    {"batch", add_batch_command},
    {"rerun", add_rerun_command},
    {"lab", add_lab_command},
    {"view", add_view_command},
    {"mark", add_mark_command},
#if !ARKMESH_CAMERAS
    {"config", add_config_command},
#endif
    {"controller", add_controller_command}
  };
  return arkmesh::cli::main(argc, argv, own);
}
