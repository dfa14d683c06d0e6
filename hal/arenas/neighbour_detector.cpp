// Reads no more of these messages than who sent them; a foreign message may be of another version.
#include "hal/arenas/neighbour_detector.hpp"

#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/bus/sender.hpp"

namespace arkmesh::hal {
NeighbourDetector::NeighbourDetector(Bus& bus, std::function<void(const Talker&)> heard)
    : heard_(std::move(heard)),
      status_(bus.subscribe(channel::status,
                            [this](std::string_view, auto bytes) { hear(false, lab_status_t::getHash(), bytes); })),
      peers_(bus.subscribe(channel::peers,
                           [this](std::string_view, auto bytes) { hear(true, peers_t::getHash(), bytes); })) {}

void NeighbourDetector::hear(bool is_gateway, std::int64_t fingerprint, std::span<const std::byte> bytes) {
  const auto sender = read_sender(bytes, fingerprint);
  if (!sender) return counters_.add(is_gateway ? "bus.ignored.peers" : "bus.ignored.status");
  heard_({.lab = sender->lab, .is_gateway = is_gateway, .number = sender->number});
}

}  // namespace arkmesh::hal
