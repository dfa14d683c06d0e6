// A line to an overhead controller that comes back: whole packets go in, and a wire that was unplugged is opened again,
// by its name, with growing pauses. Time is the caller's.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/counters.hpp"
#include "hal/platforms/kilobot/packet.hpp"
#include "hal/platforms/kilobot/wire.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::hal::kilobot {

// Monotonic time, as callers pass it in.
using hal::TimePoint;

class SerialLine {
 public:
  // `counters` outlives the line: `overhead.line_opened`, `.line_lost`, `.packet_cut` (a packet was on its way when it
  // was lost).
  SerialLine(std::unique_ptr<Wire> wire, Counters& counters) : wire_(std::move(wire)), counters_(counters) {}

  // Opens or reopens the wire when that is due, and writes what is left of a packet. Call it often. Never blocks.
  void poll(TimePoint now);
  bool is_open() const { return state_ == Wire::State::open; }
  // Open, the last packet handed over, and few bytes waiting in the system's buffers: they would come out in a burst
  // later.
  bool is_free() const;
  // Takes the packet; some of it may be written by later calls of poll(). Call it only when free.
  void send(const Packet& packet, TimePoint now);
  // When the last byte of the last packet was handed over; meaningful when free.
  TimePoint handed_over() const { return handed_over_; }
  // Grows each time the wire opens.
  std::uint64_t openings() const { return openings_; }
  // Why it is not open, one sentence; empty while nothing went wrong.
  const std::string& trouble() const { return wire_->trouble(); }

 private:
  void pump(TimePoint now);

  std::unique_ptr<Wire> wire_;
  Counters& counters_;
  Wire::State state_ = Wire::State::closed;
  TimePoint try_at_ = TimePoint::min();
  std::chrono::milliseconds pause_{0};
  std::uint64_t openings_ = 0;
  Packet packet_{};
  std::size_t left_ = 0;  // bytes of packet_ to be written
  TimePoint handed_over_{};
};

}  // namespace arkmesh::hal::kilobot
