#include "tests/examples/rover/protocol.hpp"

#include <boost/crc.hpp>
#include <boost/endian/conversion.hpp>

namespace arkmesh::examples::rover {
namespace {

constexpr std::byte start{0xd7};
constexpr std::size_t crc_at = packet_bytes - 2;

unsigned char* at(PacketBytes& bytes, std::size_t place) {
  return reinterpret_cast<unsigned char*>(&bytes[place]);
}
const unsigned char* at(std::span<const std::byte, packet_bytes> bytes, std::size_t place) {
  return reinterpret_cast<const unsigned char*>(&bytes[place]);
}

std::uint16_t checksum(std::span<const std::byte, packet_bytes> bytes) {
  boost::crc_ccitt_type crc;
  crc.process_bytes(&bytes[1], crc_at - 1);
  return static_cast<std::uint16_t>(crc.checksum());
}

}  // namespace

PacketBytes encode(const Packet& packet) {
  PacketBytes bytes{start, static_cast<std::byte>(packet.type)};
  boost::endian::store_little_u16(at(bytes, 2), packet.robot);
  bytes[4] = static_cast<std::byte>(packet.kind);
  boost::endian::store_little_s32(at(bytes, 5), packet.value);
  boost::endian::store_little_u16(at(bytes, crc_at), checksum(bytes));
  return bytes;
}

std::optional<Packet> decode(std::span<const std::byte, packet_bytes> bytes) {
  if (bytes[0] != start || bytes[1] > static_cast<std::byte>(Packet::Type::stands)) return {};
  if (boost::endian::load_little_u16(at(bytes, crc_at)) != checksum(bytes)) return {};
  return Packet{.type = static_cast<Packet::Type>(bytes[1]),
                .robot = boost::endian::load_little_u16(at(bytes, 2)),
                .kind = static_cast<std::uint8_t>(bytes[4]),
                .value = boost::endian::load_little_s32(at(bytes, 5))};
}

std::vector<Packet> PacketReader::read(std::span<const std::byte> bytes) {
  held_.insert(held_.end(), bytes.begin(), bytes.end());
  std::span<const std::byte> rest(held_);
  std::vector<Packet> packets;
  while (rest.size() >= packet_bytes) {
    if (const auto packet = decode(rest.first<packet_bytes>())) {
      packets.push_back(*packet);
      rest = rest.subspan(packet_bytes);
    } else {  // a packet may begin at the next byte
      ++damaged_bytes_;
      rest = rest.subspan(1);
    }
  }
  held_.erase(held_.begin(), held_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return packets;
}

}  // namespace arkmesh::examples::rover
