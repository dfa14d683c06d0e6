// All scenarios of this build. A new one is a folder and one line here.
#include "scenarios/dhtf/dhtf.hpp"
#include "scenarios/scenario.hpp"

namespace arkmesh::scenarios {

std::vector<CatalogueEntry>& catalogue() {
  static std::vector<CatalogueEntry> entries = {
      {"dhtf",
       [](const hal::Section& settings, const std::vector<std::string>& labs) -> std::unique_ptr<Scenario> {
         return std::make_unique<dhtf::Dhtf>(dhtf::read_settings(settings, labs));
       }},
  };
  return entries;
}

}  // namespace arkmesh::scenarios
