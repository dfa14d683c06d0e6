#include "hal/platforms/kilobot/packet_sender.hpp"

#include <algorithm>
#include <cassert>

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds look_again = 5ms, look_at_line = 20ms;

bool repeats(const Packet& packet) {
  const auto type = static_cast<PacketType>(packet[1]);
  return type == PacketType::forward || type == PacketType::forward_raw;
}

}  // namespace

void PacketSender::poll(TimePoint now) {
  port_.poll(now);
  if (port_.openings() != openings_) {
    openings_ = port_.openings();
    last_.reset();
    hold_ = 0us;
    up_ = false;
    settled_at_ = now + (at_once_ ? 0us : settle_);
  }
  if (!port_.is_open()) {
    up_ = false;
    last_.reset();
  } else if (!up_ && now >= settled_at_ && port_.is_free()) {
    up_ = true;
    // not the stop that may have been the last packet before
    put(stop_packet(static_cast<std::uint8_t>(1 + openings_ % 64)), stop_spacing, now);
  }
}

bool PacketSender::is_ready(TimePoint now) const {
  return up_ && port_.is_free() && now >= may_begin();
}

TimePoint PacketSender::due(TimePoint now) const {
  if (!up_ || !port_.is_free()) return now + look_again;
  const TimePoint next = may_begin();
  return next > now ? std::min(next, now + look_at_line) : now + look_again;
}

// A packet whose bytes the system took late is on the air late.
TimePoint PacketSender::may_begin() const {
  return std::max(begun_ + hold_, port_.handed_over() + hold_ - packet_on_line);
}

bool PacketSender::send(const Packet& packet, std::chrono::microseconds hold, TimePoint now) {
  assert(is_ready(now));
  if (last_ && *last_ == packet && (repeats(packet) || packet == stop_packet())) {
    begun_ = now;
    hold_ = hold;
    return true;
  }
  if (last_ && (*last_ == packet || false_packet_between(*last_, packet))) {
    put(parting_stop(*last_, packet), stop_spacing, now);
    counters_.add("overhead.parting_stops");
    return false;
  }
  put(packet, hold, now);
  return true;
}

void PacketSender::separate(TimePoint now) {
  assert(is_ready(now));
  const Packet last = last_.value_or(Packet{});
  put(parting_stop(last, last), stop_spacing, now);
}

bool PacketSender::is_repeating() const {
  return last_ && repeats(*last_);
}

void PacketSender::cut_short(TimePoint now) {
  // the packet itself must have come through, and with a page on the air the controller is deaf
  if (last_ && (*last_)[1] == static_cast<std::uint8_t>(PacketType::boot_page)) return;
  hold_ = std::min(hold_, std::max(stop_spacing, std::chrono::duration_cast<std::chrono::microseconds>(now - begun_)));
}

void PacketSender::put(const Packet& packet, std::chrono::microseconds hold, TimePoint now) {
  port_.send(packet, now);
  last_ = packet;
  begun_ = now;
  hold_ = hold;
  counters_.add("overhead.packets");
}

}  // namespace arkmesh::hal::kilobot
