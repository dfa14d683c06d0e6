// Finds out who talks on a lab's LCM port: labs on one UDP port hear each other whatever their multicast group, which
// would mix two labs' messages without any error.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hal/bus.hpp"
#include "hal/counters.hpp"

namespace arkmesh::hal {

// Who sent a `status` (a lab) or `peers` (a gateway) message.
struct Talker {
  std::string lab;
  bool is_gateway = false;
  std::uint64_t number = 0;  // the run id of the lab's run, or the gateway's boot id
};

class NeighbourDetector {
 public:
  // `heard` is called for each such message on `bus`, own ones included, while the detector lives. The bus outlives it.
  NeighbourDetector(Bus& bus, std::function<void(const Talker&)> heard);

  // Serves the bus for `time`, or until `enough`. Labs and gateways speak once a second.
  void listen(
      std::chrono::milliseconds time, const std::function<bool()>& enough = [] { return false; });
  // What came on these channels and names no lab: "bus.ignored.status", "bus.ignored.peers".
  const Counters& counters() const { return counters_; }

 private:
  void hear(bool is_gateway, std::int64_t fingerprint, std::span<const std::byte> bytes);

  Bus& bus_;
  std::function<void(const Talker&)> heard_;
  Counters counters_;
  std::unique_ptr<Bus::Subscription> status_, peers_;
};

}  // namespace arkmesh::hal
