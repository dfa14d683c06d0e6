// A program with every command of this build and every arena: arkmesh-testbed, and programs of your own.
#pragma once

#include <vector>

#include "app/scenarios.hpp"

namespace arkmesh::cli {

// The main() of a program that knows scenarios of its own besides arkmesh's; it links arkmesh::cli.
int main(int argc, char** argv, std::vector<app::CatalogueEntry> extra_scenarios);

}  // namespace arkmesh::cli
