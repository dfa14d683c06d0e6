// The configurations of the labs in experiments/dhtf, with overrides.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::tests {

inline std::filesystem::path experiments() {
  return std::filesystem::path(ARKMESH_SOURCE_DIR) / "experiments";
}

struct DhtfLabs {
  std::vector<std::string> labs = {"shark", "roark"};
  std::vector<std::string> overrides;  // on top of the defaults below
};

inline std::vector<hal::Config> dhtf_configs(const DhtfLabs& options) {
  std::string names;
  for (const std::string& lab : options.labs) names += (names.empty() ? "\"" : ",\"") + lab + "\"";
  std::vector<std::string> overrides = {"shared.labs=[" + names + "]", "recorder.log=false", "run.duration_s=120"};
  overrides.insert(overrides.end(), options.overrides.begin(), options.overrides.end());
  std::vector<hal::Config> configs;
  for (const std::string& lab : options.labs)
    configs.push_back(hal::Config::from_file(experiments() / "dhtf" / (lab + ".toml"), overrides));
  return configs;
}

}  // namespace arkmesh::tests
