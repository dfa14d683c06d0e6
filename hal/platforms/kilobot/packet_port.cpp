#include "hal/platforms/kilobot/packet_port.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds try_each = 250ms;  // robots may walk until the line is back
// A network path may hold some packets on their way; what waits longer than these is not current any more.
constexpr std::size_t max_waiting_bytes = 4 * packet_bytes;

}  // namespace

void PacketPort::poll(TimePoint now) {
  if (state_ == ByteStream::State::closed) {
    if (now < try_at_) return;
    try_at_ = now + try_each;
    stream_->open();
  }
  const ByteStream::State before = std::exchange(state_, stream_->check());
  if (state_ == ByteStream::State::open && before != ByteStream::State::open) {
    ++openings_;
    counters_.add("overhead.port_opened");
    left_ = 0;
    handed_over_ = now;
  }
  if (state_ == ByteStream::State::open) pump(now);
  if (state_ == ByteStream::State::closed && before == ByteStream::State::open) {
    counters_.add("overhead.port_lost");
    if (std::exchange(left_, 0) > 0) counters_.add("overhead.dropped.packet");
    try_at_ = now;
  }
}

bool PacketPort::is_free() const {
  return state_ == ByteStream::State::open && left_ == 0 && stream_->waiting_bytes() <= max_waiting_bytes;
}

void PacketPort::send(const Packet& packet, TimePoint now) {
  assert(left_ == 0 && "one packet at a time");
  packet_ = packet;
  left_ = packet.size();
  pump(now);
}

void PacketPort::pump(TimePoint now) {
  if (left_ == 0) return;
  left_ -= stream_->write(std::span<const std::uint8_t>(packet_).last(left_));
  if (left_ == 0) handed_over_ = now;
}

}  // namespace arkmesh::hal::kilobot
