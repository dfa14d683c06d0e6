// Reads what a batch is made from, docs/batches.md: an experiment file, or the files of its labs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/batch/batch_plan.hpp"

namespace arkmesh::app {

struct BatchFile {
  BatchPlan plan;
  std::filesystem::path experiment;          // empty when labs' files were given
  std::vector<std::filesystem::path> files;  // that the experiment was read from
};

// `files`: an experiment file, or labs' files, of at least one. Judges names, ranges and seeds, and that the labs'
// files are there; keys of labs are judged when labs are made. `seeds` ("1..5") replaces the experiment's, `sets` are
// further overrides of all runs; both as the command line gives them. Throws ConfigError.
BatchFile read_batch_file(const std::vector<std::filesystem::path>& files, const std::string& seeds,
                          const std::vector<std::string>& sets);

}  // namespace arkmesh::app
