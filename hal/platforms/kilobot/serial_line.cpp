#include "hal/platforms/kilobot/serial_line.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds first_pause = 100ms, longest_pause = 2000ms;
// A network path may hold some packets on their way; what waits longer than these is not current any more.
constexpr std::size_t max_waiting_bytes = 4 * packet_bytes;

}  // namespace

void SerialLine::poll(TimePoint now) {
  if (state_ == Wire::State::closed) {
    if (now < try_at_) return;
    pause_ = std::clamp(2 * pause_, first_pause, longest_pause);
    try_at_ = now + pause_;
    wire_->open();
  }
  const Wire::State before = std::exchange(state_, wire_->check());
  if (state_ == Wire::State::open && before != Wire::State::open) {
    ++openings_;
    counters_.add("overhead.line_opened");
    pause_ = 0ms;
    left_ = 0;
    handed_over_ = now;
  }
  if (state_ == Wire::State::open) pump(now);
  if (state_ == Wire::State::closed && before == Wire::State::open) {
    counters_.add("overhead.line_lost");
    if (std::exchange(left_, 0) > 0) counters_.add("overhead.packet_cut");
    pause_ = first_pause;
    try_at_ = now + pause_;
  }
}

bool SerialLine::is_free() const {
  return state_ == Wire::State::open && left_ == 0 && wire_->waiting_bytes() <= max_waiting_bytes;
}

void SerialLine::send(const Packet& packet, TimePoint now) {
  assert(left_ == 0 && "one packet at a time");
  packet_ = packet;
  left_ = packet.size();
  pump(now);
}

void SerialLine::pump(TimePoint now) {
  if (left_ == 0) return;
  left_ -= wire_->write(std::span<const std::uint8_t>(packet_).last(left_));
  if (left_ == 0) handed_over_ = now;
}

}  // namespace arkmesh::hal::kilobot
