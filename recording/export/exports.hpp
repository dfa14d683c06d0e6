// A run written for other programs. Each returns what it wrote in words, and what it left out; throws
// std::runtime_error with one sentence.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recording/run.hpp"

namespace arkmesh::recording {

struct Exported {
  std::string summary;             // "48 tables with 1234567 rows"
  std::vector<std::string> notes;  // what is left out, and why: one sentence each
};

// A folder of CSV files, one folder in it for each lab.
Exported export_csv(const Run& run, const std::filesystem::path& folder);
// One HDF5 file, a group for each lab.
Exported export_hdf5(const Run& run, const std::filesystem::path& file);
// One MCAP file; topics are /LAB/CHANNEL, and /LAB/scene for what is drawn.
Exported export_mcap(const Run& run, const std::filesystem::path& file);

}  // namespace arkmesh::recording
