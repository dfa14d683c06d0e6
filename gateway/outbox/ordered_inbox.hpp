// Which of a peer's `ordered` messages have arrived: drops what comes twice, and counts what will never come. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "hal/counters.hpp"

namespace arkmesh::gateway {

class OrderedInbox {
 public:
  static constexpr std::size_t max_channels = 256;  // whose messages are taken
  // The peer's gateway was started (again): it numbers anew. Returns how many of the messages that the earlier one
  // announced did not come.
  std::uint64_t begin();
  // `sequence`: 0 for a message of another delivery, which is always taken. False when it came before.
  bool take(std::string_view channel, std::uint64_t sequence);
  // From the peer's heartbeats: its `ordered` messages for us since its start, and those of them that wait.
  void announced(std::uint64_t accepted, std::uint64_t pending);

  // received.refused.too_many_channels, received.repeated.CHANNEL, received.missing.CHANNEL (the peer had no room for
  // them), received.missing.restart.
  const hal::Counters& counters() const { return counters_; }

 private:
  std::map<std::string, std::uint64_t, std::less<>> newest_;  // sequence by channel
  // Of all channels: announced; and that came or are known to be missing, from the first heartbeat on.
  std::uint64_t announced_ = 0;
  std::optional<std::uint64_t> settled_;
  std::uint64_t came_before_ = 0;  // before the first heartbeat
  hal::Counters counters_;
};

}  // namespace arkmesh::gateway
