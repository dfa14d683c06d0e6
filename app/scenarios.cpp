// All scenarios of this build. A new one is a folder and one line here.
#include "app/scenarios.hpp"

#include "scenarios/cre/cre.hpp"
#include "scenarios/dhtf/dhtf.hpp"
#include "scenarios/light_up/light_up.hpp"

namespace arkmesh::app {

std::vector<CatalogueEntry>& catalogue() {
  static std::vector<CatalogueEntry> entries = {
      {.name = "dhtf",
       .make = [](const hal::Section& settings,
                  const std::vector<std::string>& labs) -> std::unique_ptr<lab::Scenario> {
         return std::make_unique<scenarios::dhtf::Dhtf>(scenarios::dhtf::read_settings(settings, labs));
       },
       .keys = [] { return hal::keys_of<scenarios::dhtf::Settings>("scenario.dhtf"); },
       .kinds = 3,
       .values = 1024},
      {.name = "cre",
       .make = [](const hal::Section& settings,
                  const std::vector<std::string>& labs) -> std::unique_ptr<lab::Scenario> {
         return std::make_unique<scenarios::cre::Cre>(scenarios::cre::read_settings(settings, labs));
       },
       .keys = [] { return hal::keys_of<scenarios::cre::Settings>("scenario.cre"); },
       .kinds = 6,
       .values = 1024},
      scenario_with<scenarios::light_up::LightUp, scenarios::light_up::Settings>("light_up", 2),
  };
  return entries;
}

}  // namespace arkmesh::app
