// Frames on a byte stream between two gateways: length-prefixed, with checksums over header and payload. Knows nothing
// of sockets. All integers are big-endian; the layout is in gateway/PROTOCOL.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::gateway {

enum class FrameKind : std::uint32_t {
  hello = 1,      // who I am and what I export; the first frame of each side
  message = 2,    // one message of an exported channel
  heartbeat = 3,  // I am alive, and your hello was accepted (heartbeat.hpp)
  bye = 4,        // the reason why I close, in words
  part = 5,       // the next piece of a message that is longer than a frame; other frames may come between
  last_part = 6,  // its last piece
  ack = 7,        // what I have published of yours (heartbeat.hpp)
  channels = 8,   // what I export from now on (hello.hpp)
};

inline constexpr std::size_t frame_header_bytes = 16;
// No frame is longer: a small message waits for one frame of a large one, not for all of it.
inline constexpr std::size_t max_frame_payload_bytes = 16'384;
inline constexpr std::size_t max_frame_bytes = frame_header_bytes + max_frame_payload_bytes;
// Of the payload of a message, beside channel name and bytes.
inline constexpr std::size_t message_overhead_bytes = 8 + 1;

std::vector<std::byte> encode_frame(FrameKind kind, std::span<const std::byte> payload);
// A message as it goes on the byte stream: one frame, or parts that are as long as frames may be but for the last.
// `channel`: at most 127 bytes. `sequence`: of an `ordered` message, from 1 on in each channel; 0: it has none.
std::vector<std::byte> encode_message(std::string_view channel, std::span<const std::byte> bytes,
                                      std::uint64_t sequence = 0);

// Whether a message, or a part of one, begins here; of frames that we made ourselves.
bool is_message_frame(std::span<const std::byte> frame);

struct MessageView {
  std::string_view channel;
  std::uint64_t sequence;
  std::span<const std::byte> bytes;
};
// Views into `payload`; nothing when it is no message.
std::optional<MessageView> read_message(std::span<const std::byte> payload);

struct Message {
  std::string channel;
  std::uint64_t sequence = 0;
  std::vector<std::byte> bytes;
};
// What encode_message() made these frames of; nothing when they are damaged, incomplete, or not of one message.
std::optional<Message> decode_message(std::span<const std::byte> frames);

// CRC-32C (Castagnoli), as in iSCSI, of both parts one after the other.
std::uint32_t crc32c(std::span<const std::byte> first, std::span<const std::byte> second = {});

class FrameDecoder {
 public:
  struct Frame {
    FrameKind kind;
    std::span<const std::byte> payload;
  };
  enum class Fault { none, bad_header, bad_kind, bad_length, bad_checksum };

  // Longer payloads are a fault before any memory is asked for.
  explicit FrameDecoder(std::size_t max_payload_bytes) : max_payload_bytes_(max_payload_bytes) {}

  // Takes bytes from the front of `bytes`, up to the end of the next frame, and returns that frame when it is complete.
  // Call it until it returns nothing. The frame is valid until the next call, and as long as the bytes given. After a
  // fault it takes nothing more.
  std::optional<Frame> next(std::span<const std::byte>& bytes);
  Fault fault() const { return fault_; }
  // In words, with the numbers that matter.
  const std::string& error() const { return error_; }
  // Memory held for an incomplete frame.
  std::size_t held_bytes() const { return partial_.capacity(); }

 private:
  bool check_header(std::span<const std::byte> header);
  std::optional<Frame> finish(std::span<const std::byte> whole);
  void fail(Fault fault, std::string error);

  std::size_t max_payload_bytes_;
  std::vector<std::byte> partial_;  // beginning of an incomplete frame
  bool returned_partial_ = false;   // partial_ holds the frame that was returned last
  std::size_t payload_bytes_ = 0;   // of the frame whose header is complete
  FrameKind kind_ = FrameKind::heartbeat;
  Fault fault_ = Fault::none;
  std::string error_;
};

// Joins the parts of messages that are longer than a frame; holds no more than came.
class MessageAssembler {
 public:
  // The payload of a message that is complete with this frame, which is a message or a part; valid until the next call
  // and as long as the frame. Nothing, and overflowed(), when the parts are longer than `max_bytes`.
  std::optional<std::span<const std::byte>> take(const FrameDecoder::Frame& frame, std::size_t max_bytes);
  bool overflowed() const { return overflowed_; }
  std::size_t held_bytes() const { return parts_.capacity(); }

 private:
  std::vector<std::byte> parts_;
  bool complete_ = false;  // parts_ was returned last
  bool overflowed_ = false;
};

// "bad_header", ...: the name under which a fault is counted.
std::string_view to_text(FrameDecoder::Fault fault);

}  // namespace arkmesh::gateway
