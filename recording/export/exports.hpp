// A run written for other programs. Each returns what it wrote in words, and what it left out; throws
// std::runtime_error with one sentence, and Stopped;
// what was begun is then taken away.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recording/export/watch.hpp"
#include "recording/run.hpp"

namespace arkmesh::recording {

struct Exported {
  std::string summary;             // "48 tables with 1234567 rows"
  std::vector<std::string> notes;  // what is left out, and why: one sentence each
};

// A folder of CSV files, one folder in it for each lab.
Exported export_csv(const Run& run, const std::filesystem::path& folder, Watch& watch);
// One HDF5 file, a group for each lab.
Exported export_hdf5(const Run& run, const std::filesystem::path& file, Watch& watch);
// One MCAP file; topics are /LAB/CHANNEL, and /LAB/scene for what is drawn.
Exported export_mcap(const Run& run, const std::filesystem::path& file, Watch& watch);

}  // namespace arkmesh::recording
