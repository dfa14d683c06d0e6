// The frame codec: what is accepted, and that nothing else is.
#include "gateway/frame/frame.hpp"

#include <doctest/doctest.h>

#include <boost/crc.hpp>
#include <string>
#include <vector>

#include "hal/random.hpp"

namespace arkmesh::gateway {
namespace {

using Fault = FrameDecoder::Fault;

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}
std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

const std::string no_number(8, '\0');

void put_u32(std::vector<std::byte>& frame, std::size_t at, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) frame[at + static_cast<std::size_t>(i)] = static_cast<std::byte>(value >> (24 - 8 * i));
}

// A header whose own checksum is right, whatever it says.
std::vector<std::byte> header(std::uint32_t length, std::uint32_t kind) {
  std::vector<std::byte> out(frame_header_bytes);
  put_u32(out, 0, length);
  put_u32(out, 4, kind);
  put_u32(out, 8, crc32c(std::span(out).first(8)));
  put_u32(out, 12, crc32c(std::span(out).first(12)));
  return out;
}

// All frames of a stream that arrives in pieces of the sizes that `piece` gives, as "kind:payload".
template <class Piece>
std::vector<std::string> decode(FrameDecoder& decoder, std::span<const std::byte> stream, Piece piece) {
  std::vector<std::string> out;
  while (!stream.empty()) {
    const std::size_t size = std::min<std::size_t>(stream.size(), piece());
    // A copy of its own, so that a sanitizer sees any look beyond the piece.
    const std::vector<std::byte> copy(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(size));
    stream = stream.subspan(size);
    std::span<const std::byte> rest(copy);
    while (const auto frame = decoder.next(rest))
      out.push_back(std::to_string(static_cast<int>(frame->kind)) + ":" + text_of(frame->payload));
  }
  return out;
}

std::vector<std::byte> operator+(std::vector<std::byte> a, const std::vector<std::byte>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST_CASE("the checksum is CRC-32C") {
  // The values of RFC 3720, appendix B.4, and the usual check value; two parts give the same as one.
  CHECK(crc32c(bytes_of("123456789")) == 0xE3069283);
  CHECK(crc32c(std::vector<std::byte>(32, std::byte{0})) == 0x8A9136AA);
  CHECK(crc32c(std::vector<std::byte>(32, std::byte{0xff})) == 0x62A8AB43);
  std::vector<std::byte> rising;
  for (int i = 0; i < 32; ++i) rising.push_back(static_cast<std::byte>(i));
  CHECK(crc32c(rising) == 0x46DD794E);
  // Whatever the processor offers, Boost's table gives the same for every length.
  hal::RandomStream random(3, "crc");
  std::vector<std::byte> noise;
  for (int size = 0; size < 300; ++size) {
    boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> expected;
    expected.process_bytes(noise.data(), noise.size());
    CHECK(crc32c(noise) == expected.checksum());
    noise.push_back(static_cast<std::byte>(random.next()));
  }
  for (std::size_t cut = 0; cut <= rising.size(); ++cut)
    CHECK(crc32c(std::span(rising).first(cut), std::span(rising).subspan(cut)) == 0x46DD794E);
}

TEST_CASE("the layout of a frame") {
  // The bytes of one message, written out: a change of the layout needs another protocol version.
  const auto frame = encode_message("world", bytes_of("ab"), 0x4142);
  REQUIRE(frame.size() == frame_header_bytes + message_overhead_bytes + 7);
  const std::uint8_t expected[] = {0, 0, 0, 16, 0, 0, 0, 2};
  for (std::size_t i = 0; i < 8; ++i) CHECK(static_cast<int>(frame[i]) == expected[i]);
  CHECK(text_of(std::span(frame).subspan(frame_header_bytes)) == no_number.substr(2) + "AB\x05worldab");
  CHECK(frame.capacity() == frame.size());
}

TEST_CASE("frames arrive in pieces of any size") {
  // A stream cut anywhere, down to single bytes, gives the same frames.
  const auto stream = encode_frame(FrameKind::hello, bytes_of("who")) + encode_frame(FrameKind::heartbeat, {}) +
                      encode_message("world", bytes_of(std::string(300, 'w'))) +
                      encode_frame(FrameKind::bye, bytes_of("end"));
  const std::vector<std::string> expected = {"1:who", "3:", "2:" + no_number + "\x05world" + std::string(300, 'w'),
                                             "4:end"};
  for (std::size_t size = 1; size <= stream.size(); ++size) {
    FrameDecoder decoder(1000);
    CHECK(decode(decoder, stream, [&] { return size; }) == expected);
  }
  hal::RandomStream random(1, "frame_test");
  for (int run = 0; run < 500; ++run) {
    FrameDecoder decoder(1000);
    CHECK(decode(decoder, stream, [&] { return 1 + random.below(40); }) == expected);
  }
}

TEST_CASE("a truncated frame is no frame and no fault") {
  // Every proper beginning of a frame only waits for more.
  const auto frame = encode_message("world", bytes_of("some bytes"));
  for (std::size_t size = 0; size < frame.size(); ++size) {
    FrameDecoder decoder(1000);
    std::span<const std::byte> part = std::span(frame).first(size);
    CHECK_FALSE(decoder.next(part).has_value());
    CHECK(part.empty());
    CHECK(decoder.fault() == Fault::none);
  }
}

TEST_CASE("every single flipped bit is noticed") {
  // A frame with any one bit inverted is never accepted, and a damaged header is noticed when it is complete, without
  // waiting for bytes that may never come.
  const auto good = encode_message("world", bytes_of("some bytes"));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    auto bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    for (const std::size_t piece : {std::size_t{1}, bad.size()}) {
      FrameDecoder decoder(1000);
      CHECK(decode(decoder, bad, [&] { return piece; }).empty());
      CHECK(decoder.fault() == (bit / 8 < 12 ? Fault::bad_header : Fault::bad_checksum));
      CHECK_FALSE(decoder.error().empty());
    }
    if (bit / 8 < 12) {
      FrameDecoder decoder(1000);
      decode(decoder, std::span(bad).first(frame_header_bytes), [] { return 16; });
      CHECK(decoder.fault() == Fault::bad_header);
    }
  }
}

TEST_CASE("lengths are checked before memory is asked for") {
  // A frame may be as long as the limit and no longer; 4 GiB cost nothing but the sentence.
  for (const std::uint32_t length : {101u, 4096u, 0x7fffffffu, 0xffffffffu}) {
    FrameDecoder decoder(100);
    decode(decoder, header(length, 2), [] { return 5; });
    CHECK(decoder.fault() == Fault::bad_length);
    CHECK(decoder.error() == "received a frame of " + std::to_string(length) + " bytes; the limit is 100");
    CHECK(decoder.held_bytes() == 0);
  }
  FrameDecoder decoder(100);
  CHECK(decode(decoder, encode_frame(FrameKind::bye, bytes_of(std::string(100, 'x'))), [] { return 7; }).size() == 1);
  CHECK(decoder.held_bytes() <= frame_header_bytes + 100);
}

TEST_CASE("unknown kinds are refused") {
  // Only the eight kinds exist.
  for (const std::uint32_t kind : {0u, 9u, 0x02000000u, 0xffffffffu}) {
    FrameDecoder decoder(100);
    decode(decoder, header(0, kind), [] { return 16; });
    CHECK(decoder.fault() == Fault::bad_kind);
  }
}

TEST_CASE("after a fault nothing is taken") {
  // What follows a damaged frame cannot be trusted, even when it looks well.
  FrameDecoder decoder(100);
  auto stream = encode_frame(FrameKind::heartbeat, {});
  stream[0] ^= std::byte{1};
  CHECK(decode(decoder, stream + encode_frame(FrameKind::heartbeat, {}), [] { return 1000; }).empty());
  const auto good = encode_frame(FrameKind::heartbeat, {});
  std::span<const std::byte> rest(good);
  CHECK_FALSE(decoder.next(rest).has_value());
  CHECK(rest.size() == good.size());
}

TEST_CASE("messages in frames") {
  // Channel and bytes come out as they went in; payloads without a channel are none.
  CHECK_FALSE(read_message({}).has_value());
  CHECK_FALSE(read_message(bytes_of(no_number + std::string("\0abc", 4))).has_value());
  CHECK_FALSE(read_message(bytes_of(no_number + "\x05worl")).has_value());
  CHECK_FALSE(read_message(bytes_of(no_number)).has_value());
  const std::string world = no_number + "\x05world";
  const auto empty = read_message(bytes_of(world));
  REQUIRE(empty.has_value());
  CHECK(empty->channel == "world");
  CHECK(empty->bytes.empty());
  const std::string longest(127, 'c');
  const auto frame = encode_message(longest, bytes_of("x"));
  const auto message = read_message(std::span(frame).subspan(frame_header_bytes));
  REQUIRE(message.has_value());
  CHECK(message->channel == longest);
}

TEST_CASE("long messages come in parts") {
  // A message of any length is cut into frames that are no longer than the limit, and joined again; other messages may
  // come between its parts. Parts that are longer than allowed are refused when they are.
  for (const std::size_t size :
       {std::size_t{0}, max_frame_payload_bytes - 14, max_frame_payload_bytes - 13, std::size_t{100'000}}) {
    CAPTURE(size);
    std::string text(size, 'x');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 7 % 251);
    const auto stream = encode_message("world", bytes_of(text), 5);
    CHECK(stream.capacity() == stream.size());
    const auto small = encode_message("status", bytes_of("s"));
    FrameDecoder decoder(max_frame_payload_bytes);
    MessageAssembler assembler;
    std::span<const std::byte> rest(stream);
    std::size_t frames = 0;
    std::string joined;
    while (const auto frame = decoder.next(rest)) {
      ++frames;
      if (const auto payload = assembler.take(*frame, 200'000)) {
        const auto message = read_message(*payload);
        REQUIRE(message);
        CHECK(message->channel == "world");
        CHECK(message->sequence == 5);
        joined = text_of(message->bytes);
      }
      std::span<const std::byte> between(small);
      FrameDecoder other(max_frame_payload_bytes);
      CHECK(assembler.take(*other.next(between), 200'000)->size() == small.size() - frame_header_bytes);
    }
    CHECK(joined == text);
    CHECK(frames == (size + 14 + max_frame_payload_bytes - 1) / max_frame_payload_bytes);
  }
  MessageAssembler assembler;
  const std::vector<std::byte> piece(1000);
  for (int i = 0; i < 3; ++i) CHECK_FALSE(assembler.take({FrameKind::part, piece}, 3500).has_value());
  CHECK_FALSE(assembler.overflowed());
  CHECK_FALSE(assembler.take({FrameKind::part, piece}, 3500).has_value());
  CHECK(assembler.overflowed());
  CHECK(assembler.held_bytes() <= 7000);
}

}  // namespace
}  // namespace arkmesh::gateway
