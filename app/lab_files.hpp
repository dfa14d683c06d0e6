// The files of labs that run together in one process, with overrides, read as the configurations of one shared world.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::app {

// Overrides: "key=value" for all of them, "shark:key=value" for lab shark.
struct LabFiles {
  std::vector<std::string> files, sets;
};

// Joins exactly the labs whose files are given, unless an override sets shared.labs. `seed` overrides run.seed; below
// 0: that of the files. Throws ConfigError.
std::vector<hal::Config> read_labs(const LabFiles& labs, std::int64_t seed);

}  // namespace arkmesh::app
