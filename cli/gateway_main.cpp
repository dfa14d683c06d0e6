// `arkmesh-gateway`: small enough for the smallest computer of a lab.
#include "cli/commands.hpp"
#include "cli/program.hpp"

int main(int argc, char** argv) {
  using namespace arkmesh::cli;
  static constexpr OwnCommand own[] = {{"gateway", add_gateway_command},
                                       {"keys", add_keys_command},
                                       {"explain", add_explain_command},
                                       {"reload", add_reload_command}};
  return arkmesh::cli::main(argc, argv, own);
}
