// `arkmesh-gateway`: small enough for the smallest computer of a lab.
#include "cli/commands.hpp"
#include "cli/program.hpp"

int main(int argc, char** argv) {
  using namespace arkmesh::cli;
  static constexpr OwnCommand own[] = {{"gateway", add_gateway_command}, {"keys", add_keys_command},
                                       {"stop", add_stop_command},       {"pause", add_pause_command},
                                       {"resume", add_resume_command},   {"reset", add_reset_command},
                                       {"arm", add_arm_command},         {"disarm", add_disarm_command},
                                       {"explain", add_explain_command}, {"reload", add_reload_command}};
  return arkmesh::cli::main(argc, argv, own);
}
