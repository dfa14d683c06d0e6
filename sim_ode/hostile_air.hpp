// Messages that no program of the swarm would send: what a robot's program must stand.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

class HostileAir {
 public:
  HostileAir(std::uint64_t seed, const std::string& lab) : chance_(seed, lab + "/ode/hostile") {}

  // Adds to what `robots` robots receive in a tick: for each some eight messages a second of a type from 0 to 127, half
  // of them at random, half of them the swarm's own with up to three bytes changed. `heard` keeps its order.
  void add(int robots, std::vector<Reception>& heard);

 private:
  Message message();

  hal::RandomStream chance_;
  std::vector<Message> known_;  // of the swarm, at most 64
};

}  // namespace arkmesh::sim_ode
