// The settings of CRE: section [scenario.cre], alike in all labs.
#pragma once

#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::scenarios::cre {

// Which lab plays which part.
struct Roles {
  std::string ground, flying;

  void fields(const hal::Section& roles);
};

struct Settings {
  Roles roles;
  // The world. Lengths are metres of the ground arena unless said otherwise.
  int grid = 10;                                   // places in each row and column; half of the rows are the north's
  int resources_north = 10, resources_south = 35;  // active at any time: M_N, M_S
  double resource_radius_m = 0.02;                 // a ground robot whose centre is nearer harvests
  // What robots sense and hear.
  double sense_radius_m = 0.08;    // of a flying robot's sensor; metres of its own arena
  hal::LabTime sense{1'000'000};   // from one reading to the next
  double hear_radius_m = 0.20;     // from a flying robot's projected position to a ground robot
  double wall_zone_m = 0.068;      // walls nearer than this are told to a robot; metres of its arena
  hal::LabTime repeat{1'000'000};  // interval between equal messages to a ground robot
  // What robots do; sent to them.
  double commit = 0.052;              // h
  double recruit = 0.8;               // k, of cross-inhibition, too
  double abandon = 0.01;              // a
  double weight = 0.1;                // w, of each reading
  hal::LabTime decision{10'000'000};  // tau
  hal::LabTime straight{3'000'000};   // of a ground robot that has heard a flying one
  bool decide_together = false, ignore_zeros = false, say_once = false;
  hal::LabTime rules_repeat{10'000'000};  // how often all of that is sent
  // What counts as a consensus.
  double consensus = 0.9;  // share of the flying robots that are committed to one region

  void fields(const hal::Section& cre);
  void check(const hal::Section& cre) const;
};

// Throws ConfigError; each role is a lab of `labs`, and each of these has one role.
Settings read_settings(const hal::Section& cre, const std::vector<std::string>& labs);

// All that is sent to robots about what they do.
hal::FleetCommand rules_of(const Settings& settings);

}  // namespace arkmesh::scenarios::cre
