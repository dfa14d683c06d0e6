// Finds out who talks on a lab's LCM port and group: it would mix two labs' messages without any error.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hal/bus/bus.hpp"
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
  // `heard` is called for each such message on `bus`, own ones included, while the detector lives and somebody serves
  // the bus, which outlives it. Labs and gateways speak once a second.
  NeighbourDetector(Bus& bus, std::function<void(const Talker&)> heard);

  // What came on these channels and names no lab: "bus.ignored.status", "bus.ignored.peers".
  const Counters& counters() const { return counters_; }

 private:
  void hear(bool is_gateway, std::int64_t fingerprint, std::span<const std::byte> bytes);

  std::function<void(const Talker&)> heard_;
  Counters counters_;
  std::unique_ptr<Bus::Subscription> status_, peers_;
};

}  // namespace arkmesh::hal
