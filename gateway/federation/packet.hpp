// What gateways tell each other through a server that is trusted with forwarding only: the fields of one packet. Each
// pair of labs has two streams of bytes, one each way; a packet carries pieces of the streams to one peer or to many,
// and bytes that are the same for many are in it once. The layout is in gateway/PROTOCOL.md. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace arkmesh::gateway {

// One end of a stream, by a number that its lab draws anew for each stream; nobody can guess it, so whoever names it
// has heard of it since. 0: none, or not known yet.
using StreamId = std::uint64_t;

enum class PacketKind : std::uint8_t {
  signed_open = 1,     // for many, signed by its lab
  signed_secret = 2,   // the same, and only who has the lab's group key reads it
  sealed = 3,          // for one peer, readable and writable by these two labs only
  keys = 4,            // signed: the lab's group key, sealed for each lab that it trusts
  watched_open = 5,    // signed: what the lab lets others watch
  watched_secret = 6,  // the same for those who have the group key
};

inline bool is_watched(PacketKind kind) {
  return kind == PacketKind::watched_open || kind == PacketKind::watched_secret;
}

struct PacketHead {
  PacketKind kind = PacketKind::signed_open;
  std::string from;           // lab
  std::uint64_t boot_id = 0;  // of its gateway
  std::uint64_t number = 0;   // of the packet, from 1 on
};

// Which of a lab's packets was made earlier: boot id, number.
using PacketOrder = std::pair<std::uint64_t, std::uint64_t>;
inline PacketOrder order_of(const PacketHead& head) {
  return {head.boot_id, head.number};
}

// "My end of the stream between us is `mine`; of yours I know `yours`."
struct Greeting {
  std::string to;  // lab
  StreamId mine = 0, yours = 0;
  bool asks = false;  // wants an answer
};

struct Piece {
  StreamId yours = 0, mine = 0;
  std::uint64_t offset = 0;                // of the first byte, since the stream's beginning
  std::uint64_t acknowledged = 0;          // what has come of the stream in the other direction
  bool asks_again = false;                 // something is missing behind that
  bool is_urgent = false;                  // wants to be acknowledged soon
  std::vector<std::uint16_t> chunks = {};  // numbers of PacketBody::chunks, in order
};

// "My end of this stream is no more."
struct Ending {
  StreamId yours = 0, mine = 0;
};

struct PacketBody {
  std::vector<Greeting> greetings = {};
  std::vector<Piece> pieces = {};
  std::vector<Ending> endings = {};
  std::vector<std::span<const std::byte>> chunks = {};  // views
};

// A group key, for one lab only to open.
struct SealedKey {
  std::array<std::byte, 8> reader;  // the beginning of its pin
  std::span<const std::byte> sealed;
};

// The newest message of a channel, for whoever watches.
struct Watched {
  std::string channel;
  std::span<const std::byte> bytes;
};

inline constexpr std::size_t signature_bytes = 64;
// More of any of them is no packet of ours.
inline constexpr std::size_t max_packet_entries = 4096;
// Beside the chunks: of a piece with one chunk, with the chunk's length; of a head and all counts.
inline constexpr std::size_t piece_bytes = 8 + 8 + 8 + 8 + 1 + 2 + 2, packet_overhead_bytes = 256;

std::vector<std::byte> encode_head(const PacketHead& head);
std::vector<std::byte> encode_body(const PacketBody& body);
std::vector<std::byte> encode_keys(std::span<const SealedKey> keys);
std::vector<std::byte> encode_watched(std::span<const Watched> messages);

// A packet as it came: its head, and what follows, which nobody has verified yet.
struct PacketView {
  PacketHead head;
  std::span<const std::byte> head_bytes, body;
  std::span<const std::byte> signed_bytes, signature;  // all before the signature, and that; empty when it is sealed
};
// Nothing when it is none. Views into `bytes`.
std::optional<PacketView> read_packet(std::span<const std::byte> bytes);
// Nothing when it is none, or a piece names a chunk that is not there. Views into `bytes`.
std::optional<PacketBody> read_body(std::span<const std::byte> bytes);
std::optional<std::vector<SealedKey>> read_keys(std::span<const std::byte> bytes);
std::optional<std::vector<Watched>> read_watched(std::span<const std::byte> bytes);

// Subjects of an experiment on a server. Labs' names are tokens as they are; an experiment's characters that NATS gives
// a meaning to are written as %XX.
std::string subject_root(std::string_view experiment);
// No labs' names: those have no capitals.
inline constexpr std::string_view to_all = "ALL", to_watchers = "WATCH";

}  // namespace arkmesh::gateway
