// Layout: magic, kind, lab, boot id, number | body | signature, unless it is sealed.
#include "gateway/federation/packet.hpp"

#include <fmt/format.h>

#include <cctype>

#include "gateway/frame/byte_fields.hpp"
#include "gateway/frame/channel_name.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::gateway {
namespace {

constexpr std::string_view magic = "ARKN\1";
constexpr std::uint8_t asks_again_flag = 1, urgent_flag = 2;

// How many entries follow; nothing when there are too many.
std::optional<std::size_t> take_count(FieldReader& in) {
  const std::size_t count = in.take<std::uint16_t>();
  return in.good() && count <= max_packet_entries ? std::optional(count) : std::nullopt;
}

bool take_greetings(FieldReader& in, PacketBody& body) {
  const auto count = take_count(in);
  for (std::size_t i = 0; count && i < *count; ++i) {
    Greeting& each = body.greetings.emplace_back();
    each.to = in.take_name();
    each.mine = in.take<StreamId>();
    each.yours = in.take<StreamId>();
    each.asks = in.take<std::uint8_t>() != 0;
    if (!in.good() || each.mine == 0 || !hal::is_lab_name(each.to)) return false;
  }
  return count.has_value();
}

bool take_pieces(FieldReader& in, PacketBody& body) {
  const auto count = take_count(in);
  for (std::size_t i = 0; count && i < *count; ++i) {
    Piece& each = body.pieces.emplace_back();
    each.yours = in.take<StreamId>();
    each.mine = in.take<StreamId>();
    each.offset = in.take<std::uint64_t>();
    each.acknowledged = in.take<std::uint64_t>();
    const auto flags = in.take<std::uint8_t>();
    each.asks_again = (flags & asks_again_flag) != 0;
    each.is_urgent = (flags & urgent_flag) != 0;
    const auto chunks = take_count(in);
    if (!chunks || each.mine == 0 || each.yours == 0) return false;
    for (std::size_t k = 0; k < *chunks && in.good(); ++k) each.chunks.push_back(in.take<std::uint16_t>());
    if (!in.good()) return false;
  }
  return count.has_value();
}

bool take_endings(FieldReader& in, PacketBody& body) {
  const auto count = take_count(in);
  for (std::size_t i = 0; count && i < *count; ++i) {
    Ending& each = body.endings.emplace_back();
    each.yours = in.take<StreamId>();
    each.mine = in.take<StreamId>();
    if (!in.good() || each.mine == 0 || each.yours == 0) return false;
  }
  return count.has_value();
}

bool take_chunks(FieldReader& in, PacketBody& body) {
  const auto count = take_count(in);
  for (std::size_t i = 0; count && i < *count && in.good(); ++i)
    body.chunks.push_back(in.take_bytes(in.take<std::uint32_t>()));
  return count && in.at_end();
}

}  // namespace

std::vector<std::byte> encode_head(const PacketHead& head) {
  std::vector<std::byte> out;
  put_bytes(out, std::as_bytes(std::span(magic)));
  put(out, static_cast<std::uint8_t>(head.kind));
  put_name(out, head.from);
  put(out, head.boot_id);
  put(out, head.number);
  return out;
}

std::vector<std::byte> encode_body(const PacketBody& body) {
  std::vector<std::byte> out;
  put(out, static_cast<std::uint16_t>(body.greetings.size()));
  for (const Greeting& each : body.greetings) {
    put_name(out, each.to);
    put(out, each.mine);
    put(out, each.yours);
    put(out, static_cast<std::uint8_t>(each.asks));
  }
  put(out, static_cast<std::uint16_t>(body.pieces.size()));
  for (const Piece& each : body.pieces) {
    for (const std::uint64_t word : {each.yours, each.mine, each.offset, each.acknowledged}) put(out, word);
    put(out, static_cast<std::uint8_t>((each.asks_again ? asks_again_flag : 0) | (each.is_urgent ? urgent_flag : 0)));
    put(out, static_cast<std::uint16_t>(each.chunks.size()));
    for (const std::uint16_t chunk : each.chunks) put(out, chunk);
  }
  put(out, static_cast<std::uint16_t>(body.endings.size()));
  for (const Ending& each : body.endings) {
    put(out, each.yours);
    put(out, each.mine);
  }
  put(out, static_cast<std::uint16_t>(body.chunks.size()));
  for (const auto chunk : body.chunks) {
    put(out, static_cast<std::uint32_t>(chunk.size()));
    put_bytes(out, chunk);
  }
  return out;
}

std::vector<std::byte> encode_keys(std::span<const SealedKey> keys) {
  std::vector<std::byte> out;
  put(out, static_cast<std::uint16_t>(keys.size()));
  for (const SealedKey& each : keys) {
    put_bytes(out, each.reader);
    put(out, static_cast<std::uint16_t>(each.sealed.size()));
    put_bytes(out, each.sealed);
  }
  return out;
}

std::vector<std::byte> encode_watched(std::span<const Watched> messages) {
  std::vector<std::byte> out;
  put(out, static_cast<std::uint16_t>(messages.size()));
  for (const Watched& each : messages) {
    put_name(out, each.channel);
    put(out, static_cast<std::uint32_t>(each.bytes.size()));
    put_bytes(out, each.bytes);
  }
  return out;
}

std::optional<PacketView> read_packet(std::span<const std::byte> bytes) {
  FieldReader in(bytes);
  if (in.take_text(magic.size()) != magic) return {};
  PacketView packet;
  const auto kind = in.take<std::uint8_t>();
  if (kind < static_cast<std::uint8_t>(PacketKind::signed_open) ||
      kind > static_cast<std::uint8_t>(PacketKind::watched_secret))
    return {};
  packet.head.kind = static_cast<PacketKind>(kind);
  packet.head.from = in.take_name();
  packet.head.boot_id = in.take<std::uint64_t>();
  packet.head.number = in.take<std::uint64_t>();
  if (!in.good() || !hal::is_lab_name(packet.head.from) || packet.head.boot_id == 0) return {};
  packet.body = in.rest();
  packet.head_bytes = bytes.first(bytes.size() - packet.body.size());
  if (packet.head.kind == PacketKind::sealed) return packet;
  if (packet.body.size() < signature_bytes) return {};
  packet.signature = packet.body.last(signature_bytes);
  packet.body = packet.body.first(packet.body.size() - signature_bytes);
  packet.signed_bytes = bytes.first(bytes.size() - signature_bytes);
  return packet;
}

std::optional<PacketBody> read_body(std::span<const std::byte> bytes) {
  FieldReader in(bytes);
  PacketBody body;
  if (!take_greetings(in, body) || !take_pieces(in, body) || !take_endings(in, body) || !take_chunks(in, body))
    return {};
  for (const Piece& piece : body.pieces)
    for (const std::uint16_t chunk : piece.chunks)
      if (chunk >= body.chunks.size()) return {};
  return body;
}

std::optional<std::vector<SealedKey>> read_keys(std::span<const std::byte> bytes) {
  FieldReader in(bytes);
  const auto count = take_count(in);
  std::vector<SealedKey> keys;
  for (std::size_t i = 0; count && i < *count && in.good(); ++i) {
    SealedKey& each = keys.emplace_back();
    const auto reader = in.take_bytes(each.reader.size());
    std::ranges::copy(reader, each.reader.begin());
    each.sealed = in.take_bytes(in.take<std::uint16_t>());
  }
  return count && in.at_end() ? std::optional(std::move(keys)) : std::nullopt;
}

std::optional<std::vector<Watched>> read_watched(std::span<const std::byte> bytes) {
  FieldReader in(bytes);
  const auto count = take_count(in);
  std::vector<Watched> messages;
  for (std::size_t i = 0; count && i < *count && in.good(); ++i) {
    Watched& each = messages.emplace_back();
    each.channel = in.take_name();
    each.bytes = in.take_bytes(in.take<std::uint32_t>());
    if (!is_exported_name(each.channel)) return {};
  }
  return count && in.at_end() ? std::optional(std::move(messages)) : std::nullopt;
}

std::string subject_root(std::string_view experiment) {
  std::string out = "arkmesh.";
  if (experiment.empty()) return out + "-";
  for (const char c : experiment) {
    const auto byte = static_cast<unsigned char>(c);
    out += std::isalnum(byte) || c == '_' || c == '-' ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return out;
}

}  // namespace arkmesh::gateway
