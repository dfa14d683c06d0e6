// The keys of [sensors]: how robots of this lab sense those of others. A lab's own; labs may differ in them.
#pragma once

#include "hal/config/config.hpp"

namespace arkmesh::lab {

struct SensorConfig {
  // What robots of other labs are to the virtual sensors here: nothing, robots that are counted, or also obstacles.
  enum class Presence { none, seen, no_walk } presence = Presence::seen;
  double no_walk_m = 0;  // radius of such an obstacle, in this arena; 0: the distance of two robots here that touch

  void fields(const hal::Section& sensors) {
    sensors.field("presence", presence,
                  {.help = "how virtual sensors here sense robots of other labs: not at all, seen and counted, or seen "
                           "with a no-walk zone around each",
                   .one_of = {"none", "seen", "no-walk"}});
    sensors.field("no_walk_m", no_walk_m,
                  {{0, 10}, "m", "radius of that zone, in this arena; 0: the centre distance of two touching robots"});
  }
};

}  // namespace arkmesh::lab
