#include "scenarios/dhtf/settings.hpp"

#include <fmt/format.h>

namespace arkmesh::scenarios::dhtf {

void Settings::fields(const hal::Section& dhtf) {
  enum class Cells { all, no_corners } cells = corners ? Cells::all : Cells::no_corners;
  dhtf.field("cells", cells,
             {.help = "cells for sites: all 16, or 12 with \"no_corners\"", .one_of = {"all", "no_corners"}});
  corners = cells == Cells::all;
  dhtf.field("sites", sites, {.range = {1, 16}, .help = "number of sites"});
  dhtf.field("types", types,
             {.help = "task types: easy or hard at random for each site and lab, or equal numbers with \"half\"",
              .one_of = {"random", "half", "easy", "hard"}});
  dhtf.field("site_radius_m", site_radius_m, {{0.001, 100}, "m", "radius of a site in the shared frame"});
  dhtf.field("respawn_s", respawn, {{0, 1e6}, "s", "time for which an executed task is inactive"});
  // at most what one message to a robot carries
  dhtf.field("timeouts_s", timeouts_s,
             {{1, 1023}, "s", "waiting time of a robot: easy in all labs, hard in some, hard in all"});
  dhtf.field("requirements", requirements,
             {.range = {1, 1000},
              .unit = "robots",
              .help = "robots of this lab that a task needs: [easy, hard]",
              .sample = "[2, 4]"});
  dhtf.field("wall_zone_m", wall_zone_m, {{0, 100}, "m", "robots sense walls within this distance"});
  dhtf.field("repeat_s", repeat,
             {{0.01, 1e6}, "s", "interval between repetitions to a robot that seems to have missed a message"});
  dhtf.field("nudge_site_m", nudge_site_m, {{-1, 1}, "m", "shift of the first site along x, for control runs"});
}

void Settings::check(const hal::Section& dhtf) const {
  if (!corners && sites > 12)
    dhtf.refuse("sites", "only 12 of the 16 cells are not corners; use fewer sites or cells = \"all\"");
  if (timeouts_s.size() != 3)
    dhtf.refuse("timeouts_s", "needs three numbers: easy in all labs, hard in some, hard in all");
  for (const auto& [lab, robots] : requirements)
    if (robots.size() != 2)
      dhtf.refuse(
          "requirements." + lab,
          fmt::format("give the numbers of robots of lab {0} that an easy and a hard task need: {0} = [1, 2]", lab));
}

Settings read_settings(const hal::Section& dhtf, const std::vector<std::string>& labs) {
  const auto settings = dhtf.read<Settings>();
  for (const std::string& lab : labs)
    if (!settings.requirements.contains(lab))
      dhtf.refuse(
          "requirements." + lab,
          fmt::format(
              "is missing: give the numbers of robots of lab {0} that an easy and a hard task need: {0} = [1, 2]",
              lab));
  return settings;
}

}  // namespace arkmesh::scenarios::dhtf
