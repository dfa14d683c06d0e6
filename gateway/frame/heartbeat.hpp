// What gateways tell each other of the session itself: what has arrived, and what their clocks show. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace arkmesh::gateway {

// What its sender has received in this session, in all. The payload of an ack frame.
struct Acknowledgement {
  std::uint64_t messages = 0;  // published, or refused and counted
  std::uint64_t bytes = 0;     // of the frames of messages, with headers, also of those that are not complete
};

// The payload of a heartbeat frame. Times are microseconds.
struct Heartbeat {
  Acknowledgement received;
  std::uint64_t ordered_accepted = 0;  // `ordered` messages for the peer since this gateway's start
  std::uint64_t ordered_pending = 0;   // those of them that wait or are not acknowledged
  std::int64_t time_us = 0;            // the sender's monotonic clock
  std::int64_t wall_us = 0;            // what its wall clock shows more than that
  std::int64_t echo_us = 0;            // time_us of the last heartbeat that it heard; 0: none yet
  std::int64_t held_us = 0;            // how long ago that was
};

std::vector<std::byte> encode(const Acknowledgement& received);
std::vector<std::byte> encode(const Heartbeat& heartbeat);
// Nothing when it is none.
std::optional<Acknowledgement> read_acknowledgement(std::span<const std::byte> payload);
std::optional<Heartbeat> read_heartbeat(std::span<const std::byte> payload);

}  // namespace arkmesh::gateway
