#include "app/neighbour_detector.hpp"

#include "arkmesh/lab_status_t.hpp"
#include "hal/messages.hpp"
#include "lab/wire_check.hpp"

namespace arkmesh::app {

NeighbourDetector::NeighbourDetector(hal::Bus& public_bus, std::uint64_t nonce)
    : bus_(public_bus),
      subscription_(
          bus_.subscribe(hal::channel::status, [this, nonce](std::string_view, std::span<const std::byte> bytes) {
            lab_status_t message;
            if (lab::check_status(bytes).empty() && hal::decode(bytes, message) &&
                static_cast<std::uint64_t>(message.nonce) != nonce)
              other_ = message.lab.empty() ? "unnamed" : message.lab;
          })) {}

void NeighbourDetector::listen(std::chrono::milliseconds time) {
  using WallClock = std::chrono::steady_clock;
  const auto until = WallClock::now() + time;
  while (other_.empty() && WallClock::now() < until)
    bus_.drain(std::chrono::duration_cast<std::chrono::milliseconds>(until - WallClock::now()) +
               std::chrono::milliseconds(1));
}

}  // namespace arkmesh::app
