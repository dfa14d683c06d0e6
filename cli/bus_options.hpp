// Which lab's bus a command is about: that of a lab's file, else the default one.
#pragma once

#include <string>
#include <vector>

#include "hal/bus/bus_config.hpp"

namespace CLI {
class App;
}

namespace arkmesh::cli {

struct BusOptions {
  std::string file;
  std::vector<std::string> sets;

  // This outlives the command.
  void add_to(CLI::App& command);
  // Both throw hal::ConfigError.
  hal::BusConfig bus() const;
  std::string lab() const;  // lab.name; empty without a file
  // Of a lab with real robots that says nothing: that it hangs, and what helps; empty: it does not, as far as is known.
  std::string hung_words() const;
};

}  // namespace arkmesh::cli
