// What rovers and their base say to each other: packets of eleven bytes, each with its own checksum, over a byte stream
// that may lose, change or add bytes. Knows neither the stream nor the rovers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace arkmesh::examples::rover {

struct Packet {
  enum class Type : std::uint8_t {
    tell,    // to one rover: kind and value
    show,    // to all: `robot` lights its LED, the others are dark
    go,      // to all: drive
    stand,   // to all: stand still
    answer,  // from a rover that was told something: kind and value
    shows,   // from a rover: its LED is lit
    stands,  // from a rover: it stands still
  };
  Type type = Type::stand;
  std::uint16_t robot = 0;
  std::uint8_t kind = 0;
  std::int32_t value = 0;
  bool operator==(const Packet&) const = default;
};

// Start byte, type, robot, kind, value, CRC-16 of what is between start byte and CRC; integers little-endian.
inline constexpr std::size_t packet_bytes = 11;
using PacketBytes = std::array<std::byte, packet_bytes>;
PacketBytes encode(const Packet& packet);
// Nothing when these are not the bytes of one packet.
std::optional<Packet> decode(std::span<const std::byte, packet_bytes> bytes);

// Finds packets in a stream, whatever is between them.
class PacketReader {
 public:
  // The packets that are complete with these bytes.
  std::vector<Packet> read(std::span<const std::byte> bytes);
  // Bytes that belonged to no packet.
  std::uint64_t damaged_bytes() const { return damaged_bytes_; }

 private:
  std::vector<std::byte> held_;  // shorter than a packet between two calls
  std::uint64_t damaged_bytes_ = 0;
};

}  // namespace arkmesh::examples::rover
