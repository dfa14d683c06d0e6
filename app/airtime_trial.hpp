// What labs would say to their robots, found out by a run in simulation, beside what their arenas have room for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "app/lab_files.hpp"
#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "hal/types.hpp"

namespace arkmesh::app {

// Counted in words to single robots; a whole message is three, as it takes the place of three.
struct SlotNeed {
  std::uint64_t words = 0;         // offered in the whole trial
  std::uint64_t in_one_s = 0;      // in the busiest second of lab time
  std::uint64_t second_words = 0;  // in the second that is going on
  std::int64_t second = -1;        // its number
};

struct AirtimeNeed {
  std::string lab, layout;
  std::size_t robots = 0;
  double room = 0;  // words in a second
  std::map<std::uint8_t, SlotNeed> slots;
  SlotNeed all;
  hal::Airtime air;        // what became of the messages
  std::uint64_t anew = 0;  // words to tell all robots everything again, as after a reset; not in the slots
  double seconds = 0;      // of lab time
};

// Runs the labs for `seconds` in simulation, whatever arena they use, as `arkmesh run` does, and keeps nothing. Throws
// ConfigError, also for an arena that says nothing of its airtime, and std::runtime_error when the run fails.
std::vector<AirtimeNeed> try_airtime(LabFiles labs, double seconds, hal::StopRequest& stop, hal::Progress* progress);

}  // namespace arkmesh::app
