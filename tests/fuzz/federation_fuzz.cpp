// Arbitrary bytes from a NATS server: packets, their bodies, keys; and what a trusted lab may say to a relay. Nothing
// may crash, hang or ask for memory that did not come, and nothing becomes part of a stream but what follows in it.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/federation/nats_address.hpp"
#include "gateway/federation/packet.hpp"
#include "gateway/federation/relay.hpp"
#include "gateway/frame/byte_fields.hpp"

namespace {

using namespace arkmesh::gateway;
using namespace std::chrono_literals;

void require(bool condition) {
  if (!condition) std::abort();
}

void read_as_packet(std::span<const std::byte> bytes) {
  if (const auto packet = read_packet(bytes)) {
    const auto head = encode_head(packet->head);
    require(std::ranges::equal(head, packet->head_bytes));
    require(head.size() + packet->body.size() + packet->signature.size() == bytes.size());
  }
  if (const auto keys = read_keys(bytes)) require(std::ranges::equal(encode_keys(*keys), bytes));
  if (const auto watched = read_watched(bytes)) require(std::ranges::equal(encode_watched(*watched), bytes));
  if (const auto body = read_body(bytes)) {
    // What asks for an answer, or again, is any byte but 0 there.
    const auto again = encode_body(*body);
    require(again.size() == bytes.size());
    const auto read_again = read_body(again);
    require(read_again && encode_body(*read_again) == again);
  }
}

// A peer that may say anything of streams with few numbers, so that it often says something of ours.
void speak_to_relay(std::span<const std::byte> bytes) {
  FieldReader in(bytes);
  Relay relay(1);
  Relay::Time now{100s};
  std::uint64_t put = 0, read = 0, number = 0;
  const std::vector<std::byte> some(200, std::byte{42});
  while (in.good() && !in.rest().empty()) {
    now += std::chrono::milliseconds(in.take<std::uint8_t>());
    const auto small = [&] { return static_cast<std::uint64_t>(in.take<std::uint8_t>() % 4); };
    const auto near = [&](std::uint64_t to) { return to + static_cast<std::uint64_t>(in.take<std::int8_t>()); };
    switch (in.take<std::uint8_t>() % 7) {
      case 0:
        relay.hear(Greeting{"roark", 1 + small(), small(), small() == 0}, {1, ++number});
        break;
      case 1: {
        PacketBody body;
        for (std::uint64_t n = small(); n > 0; --n)
          body.chunks.emplace_back(std::span(some).first(in.take<std::uint8_t>() % 200));
        Piece piece{.yours = 1, .mine = 1 + small(), .offset = near(read), .acknowledged = near(put)};
        piece.asks_again = small() == 0;
        for (std::uint64_t n = body.chunks.empty() ? 0 : small(); n > 0; --n)
          piece.chunks.push_back(static_cast<std::uint16_t>(in.take<std::uint8_t>() % body.chunks.size()));
        const std::size_t before = relay.unread().size();
        relay.take(piece, body, {1, ++number}, now);
        std::size_t most = 0;
        for (const auto number : piece.chunks) most += body.chunks[number].size();
        require(relay.unread().size() - before <= most);
        break;
      }
      case 2:
        relay.hear(Ending{.yours = 1, .mine = 1 + small()});
        break;
      case 3: {
        auto chunk = std::make_shared<Chunk>();
        chunk->bytes.resize(1 + in.take<std::uint8_t>());
        chunk->is_message = small() == 0;
        put += chunk->bytes.size();
        relay.put(chunk);
        break;
      }
      case 4:
        relay.send_all_again();
        break;
      case 5:
        read += relay.unread().size();
        relay.unread().clear();
        break;
      default:
        relay.check(now);
        if (relay.owes_answer(now) || relay.next()) {
          const Piece piece = relay.piece();
          require(piece.mine == 1 && piece.acknowledged == read + relay.unread().size() && piece.offset <= put);
          if (relay.next()) relay.sent(now);
          require(!relay.owes_answer(now));
        }
        relay.has_fresh_message();
    }
    require(relay.unread().size() <= Relay::max_unread_bytes);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  read_as_packet(bytes);
  if (size > 0) speak_to_relay(bytes);
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (why_no_servers(text).empty()) require(!read_servers(text, false).all.empty());
  require(subject_root(text).find_first_of(" *>\r\n") == std::string::npos);
  return 0;
}
