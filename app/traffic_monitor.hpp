// What came from each peer, and what our gateway last said of the link. Counted here, because a gateway that was killed
// and started again counts from 0.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "hal/bus.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {

class TrafficMonitor {
 public:
  // Listens to a lab's private bus, which outlives it.
  explicit TrafficMonitor(hal::Bus& private_bus);
  const std::map<std::string, lab::Traffic>& by_peer() const { return by_peer_; }

 private:
  std::map<std::string, lab::Traffic> by_peer_;
  std::unique_ptr<hal::Bus::Subscription> arrived_, links_;
};

}  // namespace arkmesh::app
