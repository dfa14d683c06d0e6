#include "app/config_keys.hpp"

#include "app/arenas.hpp"
#include "app/scenarios.hpp"
#include "gateway/config.hpp"
#include "hal/arenas/arena_config.hpp"
#include "hal/arenas/solids.hpp"
#include "hal/bus/bus_config.hpp"
#include "lab/run_config.hpp"
#include "lab/run_folder.hpp"
#include "view/view_config.hpp"

namespace arkmesh::app {

std::vector<hal::KeyRow> all_keys() {
  std::vector<hal::KeyRow> rows;
  const auto add = [&](std::vector<hal::KeyRow> more, bool in_use = true) {
    for (hal::KeyRow& row : more) {
      row.in_use = in_use;
      rows.push_back(std::move(row));
    }
  };
  add(hal::keys_of<lab::RunConfig>(""));
  add(hal::keys_of<hal::BusConfig>("bus"));
  add(hal::keys_of<ArenaUse>("arena"));
  add(hal::keys_of<hal::ArenaConfig>("arena"));
  add(hal::solids_keys(), false);
  for (const hal::ArenaRow& row : arena_rows())
    if (row.keys) add(row.keys(), row.name == ArenaUse().use);
  add(hal::keys_of<gateway::GatewayConfig>("gateway"));
  add(hal::keys_of<lab::RecorderConfig>("recorder"));
  add(hal::keys_of<view::ViewConfig>("view"));
  for (const CatalogueEntry& entry : catalogue())
    if (entry.keys) add(entry.keys(), &entry == &catalogue().front());
  return rows;
}

}  // namespace arkmesh::app
