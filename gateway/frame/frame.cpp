// Header: payload length, kind, CRC of these two, CRC of these three and the payload. The header has a CRC of its own
// so that a damaged length is noticed at once, not after waiting for bytes that never come.
#include "gateway/frame/frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/crc.hpp>
#include <boost/endian/conversion.hpp>
#include <cassert>
#include <cstring>
#include <utility>

#if defined(__x86_64__)
#include <nmmintrin.h>
#endif

namespace arkmesh::gateway {

namespace {

constexpr std::size_t header_crc_at = 8, frame_crc_at = 12;

void store(std::byte* at, std::uint32_t value) {
  boost::endian::store_big_u32(reinterpret_cast<unsigned char*>(at), value);
}
std::uint32_t load(const std::byte* at) {
  return boost::endian::load_big_u32(reinterpret_cast<const unsigned char*>(at));
}

// Appends the header with its first two words.
void begin_frame(std::vector<std::byte>& out, FrameKind kind, std::size_t payload_bytes) {
  const std::size_t begin = out.size();
  out.resize(begin + frame_header_bytes);
  store(out.data() + begin, static_cast<std::uint32_t>(payload_bytes));
  store(out.data() + begin + 4, static_cast<std::uint32_t>(kind));
}

// The checksum of a whole frame: all but the place of the checksum itself.
std::uint32_t frame_crc(std::span<const std::byte> frame) {
  return crc32c(frame.first(frame_crc_at), frame.subspan(frame_header_bytes));
}

void finish_frame(std::span<std::byte> frame) {
  store(frame.data() + header_crc_at, crc32c(frame.first(header_crc_at)));
  store(frame.data() + frame_crc_at, frame_crc(frame));
}

#if defined(__x86_64__)
// Twenty times as fast as Boost's table: with that the checksum would be most of a gateway's work.
__attribute__((target("sse4.2"))) std::uint32_t crc32c_by_instruction(std::span<const std::byte> bytes,
                                                                      std::uint32_t state) {
  std::uint64_t wide = state;
  for (; bytes.size() >= 8; bytes = bytes.subspan(8)) {
    std::uint64_t word;
    std::memcpy(&word, bytes.data(), 8);
    wide = _mm_crc32_u64(wide, word);
  }
  auto narrow = static_cast<std::uint32_t>(wide);
  for (std::byte each : bytes) narrow = _mm_crc32_u8(narrow, static_cast<unsigned char>(each));
  return narrow;
}
#endif

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> first, std::span<const std::byte> second) {
#if defined(__x86_64__)
  static const bool has_instruction = __builtin_cpu_supports("sse4.2");
  if (has_instruction) return ~crc32c_by_instruction(second, crc32c_by_instruction(first, 0xFFFFFFFF));
#endif
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  crc.process_bytes(first.data(), first.size());
  crc.process_bytes(second.data(), second.size());
  return crc.checksum();
}

std::vector<std::byte> encode_frame(FrameKind kind, std::span<const std::byte> payload) {
  std::vector<std::byte> frame;
  frame.reserve(frame_header_bytes + payload.size());
  begin_frame(frame, kind, payload.size());
  frame.insert(frame.end(), payload.begin(), payload.end());
  finish_frame(frame);
  return frame;
}

std::vector<std::byte> encode_message(std::string_view channel, std::span<const std::byte> bytes,
                                      std::uint64_t sequence) {
  assert(channel.size() <= 127);
  const auto name = std::as_bytes(std::span(channel));
  std::array<std::byte, 8> number;
  boost::endian::store_big_u64(reinterpret_cast<unsigned char*>(number.data()), sequence);
  std::size_t left = message_overhead_bytes + name.size() + bytes.size();
  const std::size_t frames = (left + max_frame_payload_bytes - 1) / max_frame_payload_bytes;

  std::vector<std::byte> out;
  out.reserve(frames * frame_header_bytes + left);
  for (std::size_t i = 0; i < frames; ++i) {
    const bool last = i + 1 == frames;
    const FrameKind kind = frames == 1 ? FrameKind::message : last ? FrameKind::last_part : FrameKind::part;
    const std::size_t begin = out.size(), payload = std::min(left, max_frame_payload_bytes);
    begin_frame(out, kind, payload);
    if (i == 0) {  // number and name fit into the first
      out.insert(out.end(), number.begin(), number.end());
      out.push_back(static_cast<std::byte>(name.size()));
      out.insert(out.end(), name.begin(), name.end());
    }
    const auto piece = bytes.first(begin + frame_header_bytes + payload - out.size());
    out.insert(out.end(), piece.begin(), piece.end());
    bytes = bytes.subspan(piece.size());
    left -= payload;
    finish_frame(std::span(out).subspan(begin));
  }
  return out;
}

bool is_message_frame(std::span<const std::byte> frame) {
  if (frame.size() < frame_header_bytes) return false;
  const auto kind = static_cast<FrameKind>(load(frame.data() + 4));
  return kind == FrameKind::message || kind == FrameKind::part || kind == FrameKind::last_part;
}

std::optional<MessageView> read_message(std::span<const std::byte> payload) {
  if (payload.size() < message_overhead_bytes) return {};
  const auto size = static_cast<std::size_t>(payload[8]);
  if (size == 0 || payload.size() < message_overhead_bytes + size) return {};
  const auto name = payload.subspan(message_overhead_bytes, size);
  return MessageView{{reinterpret_cast<const char*>(name.data()), name.size()},
                     boost::endian::load_big_u64(reinterpret_cast<const unsigned char*>(payload.data())),
                     payload.subspan(message_overhead_bytes + size)};
}

std::optional<std::span<const std::byte>> MessageAssembler::take(const FrameDecoder::Frame& frame,
                                                                 std::size_t max_bytes) {
  if (frame.kind == FrameKind::message) return frame.payload;
  if (std::exchange(complete_, false)) {
    // A peer that once sent a long message keeps no memory here for ever.
    if (parts_.capacity() > 4 * max_frame_payload_bytes) parts_ = {};
    parts_.clear();
  }
  if (parts_.size() + frame.payload.size() > max_bytes) {
    overflowed_ = true;
    return {};
  }
  parts_.insert(parts_.end(), frame.payload.begin(), frame.payload.end());
  complete_ = frame.kind == FrameKind::last_part;
  return complete_ ? std::optional<std::span<const std::byte>>(parts_) : std::nullopt;
}

std::optional<FrameDecoder::Frame> FrameDecoder::next(std::span<const std::byte>& bytes) {
  if (fault_ != Fault::none) return {};
  if (returned_partial_) {
    partial_.clear();
    returned_partial_ = false;
  }

  // The usual case: the whole frame lies in `bytes` and needs no copy.
  if (partial_.empty() && bytes.size() >= frame_header_bytes) {
    if (!check_header(bytes.first(frame_header_bytes))) return {};
    if (const std::size_t size = frame_header_bytes + payload_bytes_; bytes.size() >= size) {
      const auto whole = bytes.first(size);
      bytes = bytes.subspan(size);
      return finish(whole);
    }
  }

  const auto collect = [&](std::size_t up_to) {
    const auto part = bytes.first(std::min(bytes.size(), up_to - partial_.size()));
    partial_.insert(partial_.end(), part.begin(), part.end());
    bytes = bytes.subspan(part.size());
    return partial_.size() == up_to;
  };
  if (partial_.size() < frame_header_bytes) {
    if (!collect(frame_header_bytes)) return {};
    if (!check_header(partial_)) return {};
    partial_.reserve(frame_header_bytes + payload_bytes_);
  }
  if (!collect(frame_header_bytes + payload_bytes_)) return {};
  returned_partial_ = true;
  return finish(partial_);
}

bool FrameDecoder::check_header(std::span<const std::byte> header) {
  const std::uint32_t length = load(header.data()), kind = load(header.data() + 4);
  if (load(header.data() + header_crc_at) != crc32c(header.first(header_crc_at))) {
    fail(Fault::bad_header, "the received bytes are damaged or not of this protocol");
    return false;
  }
  if (kind < static_cast<std::uint32_t>(FrameKind::hello) || kind > static_cast<std::uint32_t>(FrameKind::channels)) {
    fail(Fault::bad_kind, fmt::format("received a frame of unknown kind {}", kind));
    return false;
  }
  if (length > max_payload_bytes_) {
    fail(Fault::bad_length, fmt::format("received a frame of {} bytes; the limit is {}", length, max_payload_bytes_));
    return false;
  }
  payload_bytes_ = length;
  kind_ = static_cast<FrameKind>(kind);
  return true;
}

std::optional<FrameDecoder::Frame> FrameDecoder::finish(std::span<const std::byte> whole) {
  if (load(whole.data() + frame_crc_at) != frame_crc(whole)) {
    fail(Fault::bad_checksum, "received a damaged frame (checksum)");
    return {};
  }
  return Frame{kind_, whole.subspan(frame_header_bytes)};
}

void FrameDecoder::fail(Fault fault, std::string error) {
  fault_ = fault;
  error_ = std::move(error);
  std::vector<std::byte>().swap(partial_);
}

std::optional<Message> decode_message(std::span<const std::byte> frames) {
  FrameDecoder decoder(max_frame_payload_bytes);
  MessageAssembler assembler;
  const std::size_t most = frames.size();
  while (const auto frame = decoder.next(frames)) {
    if (frame->kind != FrameKind::message && frame->kind != FrameKind::part && frame->kind != FrameKind::last_part)
      return {};
    const auto payload = assembler.take(*frame, most);
    if (!payload) continue;
    const auto view = read_message(*payload);
    if (!view || !frames.empty()) return {};
    return Message{std::string(view->channel), view->sequence, {view->bytes.begin(), view->bytes.end()}};
  }
  return {};
}

std::string_view to_text(FrameDecoder::Fault fault) {
  switch (fault) {
    case FrameDecoder::Fault::none:
      return "none";
    case FrameDecoder::Fault::bad_header:
      return "bad_header";
    case FrameDecoder::Fault::bad_kind:
      return "bad_kind";
    case FrameDecoder::Fault::bad_length:
      return "bad_length";
    case FrameDecoder::Fault::bad_checksum:
      return "bad_checksum";
  }
  return "unknown";
}

}  // namespace arkmesh::gateway
