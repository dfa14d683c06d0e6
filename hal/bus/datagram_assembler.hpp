// Makes messages of LCM's datagrams: LC02 holds a whole message, LC03 a fragment of one. Pure: bytes, their source and
// the time go in, messages come out. Trusts nothing in a datagram: what is unfinished is bounded in bytes, number and
// time, and everything left out is counted with its reason.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::hal {

class DatagramAssembler {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  // The socket that a datagram came from.
  struct Source {
    std::uint32_t address = 0;
    std::uint16_t port = 0;
    bool operator==(const Source&) const = default;
  };
  struct Message {
    std::string_view channel;
    std::span<const std::byte> bytes;
  };
  struct Limits {
    std::size_t bytes = 12 << 20;             // of all unfinished messages, as long as they claim to be
    std::size_t bytes_of_source = 8 << 20;    // of one source's; so also the longest message
    std::size_t messages = 64;                // unfinished
    std::chrono::milliseconds patience{500};  // from a message's first fragment to its last
  };

  DatagramAssembler() : DatagramAssembler(Limits{}) {}
  explicit DatagramAssembler(const Limits& limits) : limits_(limits) {}

  // The message that this datagram completes. It lives until the next call, and as long as the datagram.
  std::optional<Message> add(const Source& from, std::span<const std::byte> datagram, TimePoint now);
  // Forgets messages whose fragments do not come any more.
  void expire(TimePoint now);

  // What unfinished messages claim, and how many there are.
  std::size_t held_bytes() const;
  std::size_t unfinished() const { return unfinished_.size(); }
  const Counters& counters() const { return counters_; }

 private:
  struct Range {
    std::uint64_t begin, end;  // bytes of a message
  };
  struct Unfinished {
    Source from;
    std::uint32_t sequence;
    TimePoint begun;
    std::size_t size;
    std::unique_ptr<std::byte[]> bytes;
    std::string channel = {};         // empty until fragment 0 has come
    std::vector<Range> arrived = {};  // ascending; they neither touch nor overlap

    bool complete() const {
      return !channel.empty() && arrived.size() == 1 && arrived[0].end - arrived[0].begin == size;
    }
    enum class Arrival { added, repeated, overlapping, scattered };
    Arrival arrive(Range range);
  };
  using Place = std::vector<Unfinished>::iterator;

  std::optional<Message> refuse(std::string_view counter);
  std::optional<Message> add_fragment(const Source& from, std::span<const std::byte> datagram, TimePoint now);
  Place find(const Source& from, std::uint32_t sequence);
  Place begin(const Source& from, std::uint32_t sequence, std::size_t size, TimePoint now);

  Limits limits_;
  std::vector<Unfinished> unfinished_;  // the oldest first
  std::optional<Unfinished> finished_;  // handed out by the last add()
  Counters counters_;
};

}  // namespace arkmesh::hal
