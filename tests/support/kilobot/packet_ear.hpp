// What an overhead controller takes for packets in a byte stream of bytes: the last 132 bytes whenever the oldest is
// the header and their exclusive or is zero (kilolib ohc.c). Recognition only, no time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/platforms/kilobot/packet.hpp"

namespace arkmesh::tests {

class PacketEar {
 public:
  // The packet that ends with this byte, if one does.
  std::optional<hal::kilobot::Packet> hear(std::uint8_t byte) {
    std::uint8_t& oldest = ring_[at_];
    sum_ ^= oldest ^ byte;
    oldest = byte;
    at_ = (at_ + 1) % ring_.size();
    if (ring_[at_] != hal::kilobot::packet_header || sum_ != 0) return {};
    hal::kilobot::Packet packet;
    for (std::size_t i = 0; i < packet.size(); ++i) packet[i] = ring_[(at_ + i) % ring_.size()];
    return packet;
  }
  std::vector<hal::kilobot::Packet> hear(std::span<const std::uint8_t> bytes) {
    std::vector<hal::kilobot::Packet> out;
    for (const std::uint8_t byte : bytes)
      if (const auto packet = hear(byte)) out.push_back(*packet);
    return out;
  }

 private:
  hal::kilobot::Packet ring_{};
  std::size_t at_ = 0;
  std::uint8_t sum_ = 0;
};

}  // namespace arkmesh::tests
