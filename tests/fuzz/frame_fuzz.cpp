// Arbitrary bytes from a TCP connection: frames, hellos, messages. Nothing may crash, hang or ask for memory that did
// not come, and how a stream was cut into pieces must not matter.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "gateway/frame/frame.hpp"
#include "gateway/frame/heartbeat.hpp"
#include "gateway/frame/hello.hpp"
#include "gateway/outbox/ordered_inbox.hpp"
#include "gateway/session/clock_estimate.hpp"

namespace {

using namespace arkmesh::gateway;

constexpr std::size_t max_payload_bytes = 1000, max_joined_bytes = 3000;

void require(bool condition) {
  if (!condition) std::abort();
}

// What a peer says of clocks and of its own numbers may be anything.
void hear(const Heartbeat& heartbeat) {
  ClockEstimate clock;
  clock.add({heartbeat.echo_us, heartbeat.time_us - heartbeat.held_us, heartbeat.time_us, heartbeat.wall_us});
  clock.clock();
  OrderedInbox inbox;
  inbox.announced(heartbeat.ordered_accepted, heartbeat.ordered_pending);
  inbox.take("events", heartbeat.received.messages);
  inbox.take("events", heartbeat.received.bytes);
  inbox.begin();
}

// What a decoder makes of a stream that comes in pieces of one size: kinds, payloads, and the fault at the end.
std::string decode(std::span<const std::byte> stream, std::size_t piece) {
  FrameDecoder decoder(max_payload_bytes);
  MessageAssembler assembler;
  std::string out;
  while (!stream.empty()) {
    const std::vector<std::byte> copy(stream.begin(),
                                      stream.begin() + static_cast<std::ptrdiff_t>(std::min(piece, stream.size())));
    stream = stream.subspan(copy.size());
    std::span<const std::byte> rest(copy);
    while (const auto frame = decoder.next(rest)) {
      out += std::to_string(static_cast<int>(frame->kind)) + ":";
      out.append(reinterpret_cast<const char*>(frame->payload.data()), frame->payload.size());
      require(frame->payload.size() <= max_payload_bytes);
      if (const auto message = read_message(frame->payload))
        require(message_overhead_bytes + message->channel.size() + message->bytes.size() == frame->payload.size());
      if (frame->kind == FrameKind::part || frame->kind == FrameKind::last_part) {
        if (const auto joined = assembler.take(*frame, max_joined_bytes)) out += std::to_string(joined->size()) + "!";
        require(assembler.held_bytes() <= 2 * max_joined_bytes);
      }
      if (const auto received = read_acknowledgement(frame->payload))
        require(std::ranges::equal(encode(*received), frame->payload));
      if (const auto heartbeat = read_heartbeat(frame->payload)) {
        require(std::ranges::equal(encode(*heartbeat), frame->payload));
        hear(*heartbeat);
      }
    }
    require(decoder.held_bytes() <= 2 * (frame_header_bytes + max_payload_bytes));
  }
  return out + std::string(to_text(decoder.fault())) + decoder.error();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::size_t piece = 1 + data[0] % 64;
  const bool as_stream = data[1] % 2 == 0;
  const std::span bytes(reinterpret_cast<const std::byte*>(data) + 2, size - 2);

  // The bytes as they are, or as payloads of frames that are well-formed: otherwise checksums would keep the fuzzer
  // outside.
  std::vector<std::byte> stream(bytes.begin(), bytes.end());
  if (!as_stream) {
    stream.clear();
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t length = std::min<std::size_t>(static_cast<std::size_t>(bytes[at]) * 5, bytes.size() - at - 1);
      const auto frame = encode_frame(static_cast<FrameKind>(1 + at % 8), bytes.subspan(at + 1, length));
      stream.insert(stream.end(), frame.begin(), frame.end());
      at += 1 + length;
    }
  }
  require(decode(stream, piece) == decode(stream, stream.size() + 1));

  if (const auto hello = read_hello(bytes); hello && hello->version == protocol_version) {
    const auto again = encode_hello(*hello);
    require(std::ranges::equal(again, bytes));
    require(!why_refused(*hello, *hello));
  }
  return 0;
}
