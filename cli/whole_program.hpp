// A program with every command of this build and every arena: arkmesh-testbed, and programs of your own.
#pragma once

#include <utility>
#include <vector>

#include "app/scenarios.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::cli {

// For a program that finds arkmesh's programs beside itself.
int whole_main(int argc, char** argv, std::vector<app::CatalogueEntry> extra_scenarios);

// The main() of a program that knows scenarios of its own besides arkmesh's; it links arkmesh::cli. An own scenario of
// the same name as one of arkmesh's takes its place. arkmesh::cli says, to whoever compiles this, where arkmesh's
// programs lie: the user's program finds them, and the files that come with them, from any folder.
inline int main(int argc, char** argv, std::vector<app::CatalogueEntry> extra_scenarios) {
  hal::use_programs_in(ARKMESH_PROGRAM_FOLDER);
  return whole_main(argc, argv, std::move(extra_scenarios));
}

}  // namespace arkmesh::cli
