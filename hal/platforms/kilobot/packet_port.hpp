// A port to an overhead controller that comes back: whole packets go in, and a byte stream that was unplugged is opened
// again, by its name, four times a second. Time is the caller's.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/counters.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/platforms/kilobot/packet.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal::kilobot {

// Monotonic time, as callers pass it in.
using hal::TimePoint;

class PacketPort {
 public:
  // `counters` outlives the line: `overhead.port_opened`, `.port_lost`, `.dropped.packet` (a packet was on its way when
  // it was lost).
  PacketPort(std::unique_ptr<ByteStream> stream, Counters& counters)
      : stream_(std::move(stream)), counters_(counters) {}

  // Opens or reopens the byte stream when that is due, and writes what is left of a packet. Call it often. Never
  // blocks.
  void poll(TimePoint now);
  bool is_open() const { return state_ == ByteStream::State::open; }
  // Open, the last packet handed over, and few bytes waiting in the system's buffers: they would come out in a burst
  // later.
  bool is_free() const;
  // Takes the packet; some of it may be written by later calls of poll(). Call it only when free.
  void send(const Packet& packet, TimePoint now);
  // Gives a connection up with what waits in it, to be opened again by later calls of poll(). False: the line is none.
  bool reset() { return is_open() && stream_->reset(); }
  // When the last byte of the last packet was handed over; meaningful when free.
  TimePoint handed_over() const { return handed_over_; }
  // Grows each time the byte stream opens.
  std::uint64_t openings() const { return openings_; }
  // Why it is not open, one sentence; empty while nothing went wrong.
  const std::string& error() const { return stream_->error(); }

 private:
  void pump(TimePoint now);

  std::unique_ptr<ByteStream> stream_;
  Counters& counters_;
  ByteStream::State state_ = ByteStream::State::closed;
  TimePoint try_at_ = TimePoint::min();
  std::uint64_t openings_ = 0;
  Packet packet_{};
  std::size_t left_ = 0;  // bytes of packet_ to be written
  TimePoint handed_over_{};
};

}  // namespace arkmesh::hal::kilobot
