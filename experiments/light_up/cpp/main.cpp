// All commands of arkmesh, with one scenario more.
#include "cli/whole_program.hpp"
#include "scenarios/light_up/light_up.hpp"

using namespace arkmesh::scenarios::light_up;

int main(int argc, char** argv) {
  return arkmesh::cli::main(argc, argv, {arkmesh::app::scenario_with<LightUp, Settings>("light_up")});
}
