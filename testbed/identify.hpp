// Set-up procedure `identify`: which robot in an arena is which. Robots need not run.
#pragma once

#include <vector>

#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "testbed/set_up_arena.hpp"

namespace arkmesh::testbed {

struct IdentifySettings {
  // Robots whose programs have arkmesh_id.h spell their ids all at once; others know ARK's message 120 or 119 and are
  // called one by one.
  enum class Protocol : std::uint8_t { spelled, ark, ark_runtime };
  Protocol protocol = Protocol::spelled;
  std::vector<hal::RobotId> expected;  // ascending; nobody: whoever answers
  double max_s = 0;                    // 0: 120, with ARK's messages 3 for each id
};

struct IdentifyReport {
  struct Named {
    hal::RobotId robot = 0;
    hal::Pose at;
    float confidence = 0;
  };
  std::vector<Named> named;              // ascending
  std::vector<hal::Pose> nameless;       // robots that are there
  std::vector<hal::RobotId> missing;     // expected and not found
  std::vector<hal::RobotId> duplicates;  // ids that several robots have
  std::vector<hal::RobotId> strangers;   // there and not expected
  std::size_t looked_for = 0;            // robots
  double took_s = 0;                     // until the last name
  bool complete = false;                 // everybody looked for was found
  bool simulated = false;                // the arena is no real one
};

IdentifyReport identify(SetUpArena& arena, const IdentifySettings& settings, hal::StopRequest& stop,
                        hal::Progress& progress);

}  // namespace arkmesh::testbed
