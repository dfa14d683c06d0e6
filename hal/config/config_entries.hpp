// A TOML file that names keys of other files, such as a batch's: every value with the path at which it stands, in the
// order of the text. Judges nothing but TOML; includes are laid under the file as in any configuration.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::hal {

struct ConfigEntry {
  struct Value {
    std::string toml;  // as an override takes it
    std::string text;  // of a text what is between its quotes, else as `toml`
    bool is_text = false;
  };
  std::vector<std::string> path;  // {"sweep", "gate.period_s"}; of an element of a list of tables {"plot", "0", "over"}
  Value value;                    // the whole; empty for a table without keys
  std::vector<Value> elements;    // of a list
  bool is_list = false, is_table = false;  // is_table: one without keys
  std::string place;                       // "batch.toml:12"
};

struct ConfigEntries {
  std::vector<ConfigEntry> entries;
  std::vector<std::filesystem::path> files;  // that were read
};

// Throws ConfigError.
ConfigEntries read_entries(const std::filesystem::path& file);

}  // namespace arkmesh::hal
