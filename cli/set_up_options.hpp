// What the commands of set-up procedures have in common: a lab's file, and which robots.
#pragma once

#include <string>
#include <vector>

#include "hal/stop_request.hpp"
#include "testbed/set_up_arena.hpp"

namespace CLI {
class App;
}

namespace arkmesh::cli {

struct SetUpOptions {
  std::string program;  // what robots must run, the name of one in firmware/; empty: their own
  std::string file, ids, record;
  std::vector<std::string> sets;

  // The options FILE, --set and --record.
  void add_to(CLI::App& command);
  // Waits until the arena is there.
  testbed::SetUpArena open_arena(hal::StopRequest& stop) const;
  // Those of --ids, in that order. Throws CLI::ValidationError for an id above `largest` and for what is no list.
  std::vector<hal::RobotId> listed_ids(hal::RobotId largest) const;
  // To people at an arena whose robots are real.
  void say_program(const testbed::SetUpArena& arena) const;
  // To standard error, of a report: whether it is of simulated robots.
  static void say_whose_robots(bool simulated);
};

}  // namespace arkmesh::cli
