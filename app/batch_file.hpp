// Reads a batch's experiment file, docs/batches.md.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/batch_plan.hpp"

namespace arkmesh::app {

struct BatchFile {
  BatchPlan plan;
  std::vector<std::filesystem::path> files;  // that were read
};

// Judges names, ranges and seeds, and that the labs' files are there; keys of labs are judged when labs are made.
// `seeds` ("1..5") replaces the file's, `sets` are further overrides of all runs; both as the command line gives them.
// Throws ConfigError.
BatchFile read_batch_file(const std::filesystem::path& file, const std::string& seeds,
                          const std::vector<std::string>& sets);

}  // namespace arkmesh::app
