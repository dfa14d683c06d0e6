// A program of arkmesh that runs the commands of one list, ARKMESH_COMMANDS, and loads nothing that they do not need.
#include "cli/commands.hpp"

int main(int argc, char** argv) {
  return arkmesh::cli::main(argc, argv, arkmesh::cli::ARKMESH_COMMANDS);
}
