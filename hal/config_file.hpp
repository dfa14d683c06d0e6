// Reads configuration files with all they include, presets and overrides into one tree. Judges no key but `include` and
// `preset`.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "hal/config_tree.hpp"

namespace arkmesh::hal {

struct LoadedConfig {
  ConfigTree tree;
  std::string preset;  // its name; empty when none is in force
};

// `text` null: read from `file`. Throws ConfigError.
LoadedConfig load_config(const std::filesystem::path& file, const std::string_view* text,
                         const std::vector<std::string>& overrides);

}  // namespace arkmesh::hal
