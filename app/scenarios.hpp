// The only place where concrete scenarios are named: one line each in scenarios.cpp.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "lab/scenario.hpp"

namespace arkmesh::app {

struct CatalogueEntry {
  std::string name;
  // `settings` is the configuration's [scenario.<name>]; all of it must be alike in all labs. Throws ConfigError.
  std::function<std::unique_ptr<lab::Scenario>(const hal::Section& settings, const std::vector<std::string>& labs)>
      make;
  std::function<std::vector<hal::KeyRow>()> keys = nullptr;  // of its settings, for the table of all keys
  bool addresses_robots = true;                              // it says something to single robots (Lab::say)
  // Its words' kinds and values are below these, which robots' messages must have room for; by default it asks nothing.
  std::uint8_t kinds = 1;
  std::uint32_t values = 1;
};

// A scenario that is made of its settings alone, which a struct of fields holds (hal::Section::read).
template <typename Made, typename Settings>
CatalogueEntry scenario_with(const std::string& name, std::uint8_t kinds = 1, std::uint32_t values = 1) {
  return {.name = name,
          .make = [](const hal::Section& settings, const std::vector<std::string>&) -> std::unique_ptr<lab::Scenario> {
            return std::make_unique<Made>(settings.read<Settings>());
          },
          .keys = [name] { return hal::keys_of<Settings>("scenario." + name); },
          .kinds = kinds,
          .values = values};
}

// All scenarios this build knows. A program of your own may add its own before it makes labs.
std::vector<CatalogueEntry>& catalogue();

}  // namespace arkmesh::app
