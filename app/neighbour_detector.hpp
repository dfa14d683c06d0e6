// Finds another lab process on our LCM port: labs on one UDP port hear each other whatever their multicast group, which
// would mix two labs' messages without any error.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "hal/bus.hpp"

namespace arkmesh::app {

class NeighbourDetector {
 public:
  // Watches `status` on the lab's public bus; statuses with `nonce` are our own.
  NeighbourDetector(hal::Bus& public_bus, std::uint64_t nonce);
  // Serves the bus until another lab was heard, at most for `time`. A lab's status comes once a second.
  void listen(std::chrono::milliseconds time);
  // The other lab's name; empty while none was heard.
  const std::string& other() const { return other_; }

 private:
  hal::Bus& bus_;
  std::string other_;
  std::unique_ptr<hal::Bus::Subscription> subscription_;
};

}  // namespace arkmesh::app
