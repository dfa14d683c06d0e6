// `arkmesh-testbed`: labs with any arena, and everything that is done with cameras.
#include "cli/whole_program.hpp"

int main(int argc, char** argv) {
  return arkmesh::cli::main(argc, argv, std::vector<arkmesh::app::CatalogueEntry>{});
}
