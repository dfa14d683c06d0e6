// What came from each peer, and what our gateway last said of the link. Counted here, because a gateway that was killed
// and started again counts from 0.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "hal/bus/bus.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {

class TrafficMonitor {
 public:
  // Listens to a lab's private bus, which outlives it. Anybody may write there: only what comes under the names of
  // `labs` is told.
  TrafficMonitor(hal::Bus& private_bus, const std::vector<std::string>& labs);
  const std::map<std::string, lab::Traffic>& by_peer() const { return by_peer_; }

 private:
  std::set<std::string, std::less<>> labs_;
  std::map<std::string, lab::Traffic> by_peer_;
  std::unique_ptr<hal::Bus::Subscription> arrived_, links_;
};

}  // namespace arkmesh::app
