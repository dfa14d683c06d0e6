// All scenarios of this build. A new one is a folder and one line here.
#include "app/scenarios.hpp"

#include "scenarios/cre/cre.hpp"
#include "scenarios/dhtf/dhtf.hpp"
#include "scenarios/light_up/light_up.hpp"

namespace arkmesh::app {

std::vector<CatalogueEntry>& catalogue() {
  static std::vector<CatalogueEntry> entries = {
      {"dhtf",
       [](const hal::Section& settings, const std::vector<std::string>& labs) -> std::unique_ptr<lab::Scenario> {
         return std::make_unique<scenarios::dhtf::Dhtf>(scenarios::dhtf::read_settings(settings, labs));
       },
       [] { return hal::keys_of<scenarios::dhtf::Settings>("scenario.dhtf"); }},
      {"cre",
       [](const hal::Section& settings, const std::vector<std::string>& labs) -> std::unique_ptr<lab::Scenario> {
         return std::make_unique<scenarios::cre::Cre>(scenarios::cre::read_settings(settings, labs));
       },
       [] { return hal::keys_of<scenarios::cre::Settings>("scenario.cre"); }},
      scenario_with<scenarios::light_up::LightUp, scenarios::light_up::Settings>("light_up"),
  };
  return entries;
}

}  // namespace arkmesh::app
