// Packets of the example's rovers on a stream that is not kind to them.
#include "tests/examples/rover/protocol.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "hal/random.hpp"

using namespace arkmesh;
using namespace arkmesh::examples::rover;

namespace {

Packet numbered(int i) {
  return {static_cast<Packet::Type>(i % 7), static_cast<std::uint16_t>(i * 251), static_cast<std::uint8_t>(i),
          i * 1'000'003 - 5};
}

void append(std::vector<std::byte>& stream, const Packet& packet) {
  const PacketBytes bytes = encode(packet);
  stream.insert(stream.end(), bytes.begin(), bytes.end());
}

}  // namespace

TEST_CASE("rover packets: the reader finds them all, however the stream is cut and whatever lies between") {
  // A hundred packets with noise between them, start bytes among it, arrive whole in pieces of 1 to 30 bytes, and every
  // byte of noise is counted.
  hal::RandomStream random(3, "noise");
  std::vector<std::byte> stream;
  std::vector<Packet> sent;
  std::uint64_t noise = 0;
  for (int i = 0; i < 100; ++i) {
    sent.push_back(numbered(i));
    for (std::uint64_t n = random.below(15); n > 0; --n, ++noise)
      stream.push_back(random.below(3) == 0 ? std::byte{0xd7} : static_cast<std::byte>(random.below(256)));
    append(stream, sent.back());
  }
  for (std::size_t piece = 1; piece <= 30; ++piece) {
    CAPTURE(piece);
    PacketReader reader;
    std::vector<Packet> read;
    for (std::size_t at = 0; at < stream.size(); at += piece)
      for (const Packet& packet : reader.read(std::span(stream).subspan(at, std::min(piece, stream.size() - at))))
        read.push_back(packet);
    CHECK(read == sent);
    CHECK(reader.damaged_bytes() == noise);
  }
}

TEST_CASE("rover packets: a changed byte costs its packet and no other") {
  // Each byte of the middle one of three packets is changed in each of its bits.
  for (std::size_t at = packet_bytes; at < 2 * packet_bytes; ++at)
    for (int bit = 0; bit < 8; ++bit) {
      CAPTURE(at);
      CAPTURE(bit);
      std::vector<std::byte> stream;
      for (int i = 1; i <= 3; ++i) append(stream, numbered(i));
      stream[at] ^= std::byte{1} << bit;
      PacketReader reader;
      CHECK(reader.read(stream) == std::vector{numbered(1), numbered(3)});
      CHECK(reader.damaged_bytes() == packet_bytes);
    }
}
