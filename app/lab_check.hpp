// Whether labs can be made from their configurations, before anything is started, and what is in force in them.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::app {

struct CheckedLab {
  std::string name;
  std::map<std::string, std::string, std::less<>> settings;  // every key in force, but lists of tables
  std::string effective;                                     // the whole, as TOML
  std::vector<std::filesystem::path> inputs;                 // files that it was made from, the robots' program too
  std::uintmax_t keep_free_bytes = 0;                        // recorder.keep_free_mib
};

// Makes the labs as a run does, and ends them. Throws ConfigError, also when they do not agree on what all must have
// alike, or when an arena has real robots.
std::vector<CheckedLab> check_labs(const std::vector<hal::Config>& configs);

}  // namespace arkmesh::app
