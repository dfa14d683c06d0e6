// Times are those of the published firmware in an emulator: 4.371 ms a message, repeated each 10.409 ms; pages 4.443 ms
// a message.
#include "emulator/ohc_device.hpp"

#include <algorithm>
#include <limits>

namespace arkmesh::emulator {
namespace {

constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t start_up_us = 2'000'000;
constexpr std::int64_t latency_us = 200;
constexpr std::int64_t message_us = 4371, repeat_us = 10'409;
constexpr std::int64_t page_message_us = 4443, page_lamp_us = 20'000;
constexpr std::int64_t position_pause_us = 50;
constexpr std::size_t max_waiting = 4096, max_lit = 64;
constexpr std::uint8_t header = 0x55;

enum PacketType : std::uint8_t { stop, toggle_lamp, forward, forward_raw, boot_page, positions, forward_once };
constexpr const char* type_names[] = {"stop",      "led_toggle", "forward",       "forward_raw",
                                      "boot_page", "gps_frame",  "forward_single"};

}  // namespace

void OhcDevice::receive(std::uint8_t byte, std::int64_t at_us) {
  run_until(at_us);
  if (phase_ == Phase::unplugged) return counters_.add("ohc.bytes_lost.unplugged");
  if (phase_ == Phase::burst) {
    // nobody takes it out of the receiver
    if (held_count_ == held_.size()) return counters_.add("ohc.bytes_lost.deaf");
    held_[held_count_++] = byte;
    return;
  }
  push(byte, at_us);
}

void OhcDevice::push(std::uint8_t byte, std::int64_t at_us) {
  // serving it takes time that the pulses on the air lack
  if (phase_ == Phase::sending) clean_ = false;
  sum_ = static_cast<std::uint8_t>(sum_ ^ ring_[oldest_] ^ byte);
  ring_[oldest_] = byte;
  oldest_ = (oldest_ + 1) % packet_bytes;
  if (ring_[oldest_] != header || sum_ != 0) return;
  if (pending_) counters_.add("ohc.packets_overwritten");
  std::rotate_copy(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(oldest_), ring_.end(), packet_.begin());
  pending_ = true;
  const std::uint8_t type = packet_[1];
  counters_.add(type < std::size(type_names) ? std::string("ohc.packets.") + type_names[type] : "ohc.packets.unknown");
  if (phase_ == Phase::idle) enter(Phase::thinking, at_us, latency_us);
}

void OhcDevice::run_until(std::int64_t until_us) {
  while (end_us_ <= until_us) end_phase();
}

void OhcDevice::enter(Phase phase, std::int64_t now_us, std::int64_t lasts_us) {
  phase_ = phase;
  end_us_ = lasts_us == never ? never : now_us + lasts_us;
}

void OhcDevice::end_phase() {
  const std::int64_t now_us = end_us_;
  switch (phase_) {
    case Phase::thinking:
      act(now_us);
      return;
    case Phase::sending:
      send(message_, start_us_, clean_);
      enter(Phase::blinking, now_us, repeat_us - message_us);
      return;
    case Phase::blinking:
      if (pending_)
        enter(Phase::thinking, now_us, latency_us);
      else if (repeats_)
        begin_message(now_us);
      else
        enter(Phase::idle, now_us, never);
      return;
    case Phase::burst:
      end_burst(now_us);
      return;
    case Phase::starting:
    case Phase::burst_lamp:
      if (pending_)
        enter(Phase::thinking, now_us, latency_us);
      else
        enter(Phase::idle, now_us, never);
      return;
    case Phase::idle:
    case Phase::unplugged:
      end_us_ = never;
      return;
  }
}

// On the newest packet, whatever was repeated before.
void OhcDevice::act(std::int64_t now_us) {
  pending_ = repeats_ = false;
  switch (packet_[1]) {
    case forward:
    case forward_once:
    case forward_raw:
      std::copy_n(packet_.begin() + 2, message_.data.size(), message_.data.begin());
      message_.type = packet_[11];
      message_.crc = hal::kilobot::message_crc(message_);
      if (packet_[1] == forward_raw) message_.crc = static_cast<std::uint16_t>(packet_[12] | packet_[13] << 8);
      repeats_ = packet_[1] != forward_once;
      return begin_message(now_us);
    case boot_page:
      return begin_pages(now_us);
    case positions:
      return begin_positions(now_us);
    case toggle_lamp:
      lamp_ = !lamp_;
      break;
    default:
      break;
  }
  enter(Phase::idle, now_us, never);
}

void OhcDevice::begin_message(std::int64_t now_us) {
  start_us_ = now_us;
  clean_ = true;
  enter(Phase::sending, now_us, message_us);
}

// One flash page in 22 messages of three words each; the last one carries the page's end, the checksum and what lies
// behind it.
void OhcDevice::begin_pages(std::int64_t now_us) {
  constexpr std::size_t words = 64, words_per_message = 3, first_byte = 3;
  std::int64_t at_us = now_us;
  for (std::size_t word = 0; word < words; word += words_per_message, at_us += page_message_us) {
    Message part;
    part.type = hal::kilobot::type_boot_page;
    part.data[0] = packet_[2];
    part.data[1] = static_cast<std::uint8_t>(word);
    for (std::size_t k = 0; k < 2 * words_per_message; ++k) {
      const std::size_t at = first_byte + 2 * word + k;
      part.data[2 + k] = at < packet_bytes ? packet_[at] : std::uint8_t{0};
    }
    part.crc = hal::kilobot::message_crc(part);
    send(part, at_us, true);
  }
  enter(Phase::burst, now_us, at_us - now_us - page_message_us + message_us);
}

// Up to 16 entries of eight bytes, until the first that is all zero.
void OhcDevice::begin_positions(std::int64_t now_us) {
  constexpr std::size_t entries = 16, entry_bytes = 8;
  std::int64_t at_us = now_us;
  for (std::size_t entry = 0; entry < entries; ++entry, at_us += message_us + position_pause_us) {
    const auto* const from = packet_.begin() + 2 + static_cast<std::ptrdiff_t>(entry * entry_bytes);
    if (std::all_of(from, from + entry_bytes, [](std::uint8_t byte) { return byte == 0; })) break;
    Message part;
    part.type = 1;
    std::copy_n(from, entry_bytes, part.data.begin());
    part.crc = hal::kilobot::message_crc(part);
    send(part, at_us, true);
  }
  if (at_us == now_us) return enter(Phase::idle, now_us, never);
  enter(Phase::burst, now_us, at_us - now_us);
}

// Interrupts are on again: what the receiver could hold is served at once.
void OhcDevice::end_burst(std::int64_t now_us) {
  enter(Phase::burst_lamp, now_us, packet_[1] == boot_page ? page_lamp_us : 0);
  const std::size_t held = held_count_;
  held_count_ = 0;
  for (std::size_t k = 0; k < held; ++k) push(held_[k], now_us);
}

void OhcDevice::send(const Message& message, std::int64_t start_us, bool clean) {
  if (sent_.size() >= max_waiting) {
    sent_.pop_front();
    counters_.add("ohc.transmissions_dropped");
  }
  sent_.push_back({.start_us = start_us, .end_us = start_us + message_us, .message = message, .clean = clean});
  lit_.push_back({start_us, start_us + message_us});
  if (lit_.size() > max_lit) lit_.pop_front();
}

void OhcDevice::sent_until(std::int64_t until_us, std::vector<sim_ode::Transmission>& out) {
  run_until(until_us);
  while (!sent_.empty() && sent_.front().end_us <= until_us) {
    out.push_back(sent_.front());
    sent_.pop_front();
  }
}

bool OhcDevice::on_air(std::int64_t from_us, std::int64_t to_us) const {
  for (auto span = lit_.rbegin(); span != lit_.rend() && span->to_us > from_us; ++span)
    if (span->from_us < to_us) return true;
  if (phase_ == Phase::sending && start_us_ < to_us && end_us_ > from_us) return true;
  // the repetition goes on, as far as it is known now
  if (!repeats_ || pending_ || (phase_ != Phase::sending && phase_ != Phase::blinking)) return false;
  const std::int64_t next_us = start_us_ + repeat_us;
  if (to_us <= next_us) return false;
  const std::int64_t since = std::max<std::int64_t>(0, from_us - next_us), in_period = since % repeat_us;
  return in_period < message_us || since - in_period + repeat_us < to_us - next_us;
}

void OhcDevice::unplug(std::int64_t now_us) {
  run_until(now_us);
  // what was on the air breaks off
  std::erase_if(sent_, [now_us](const sim_ode::Transmission& sent) { return sent.end_us > now_us; });
  for (Span& span : lit_) span.to_us = std::min(span.to_us, now_us);
  repeats_ = pending_ = lamp_ = false;
  enter(Phase::unplugged, now_us, never);
}

void OhcDevice::plug_in(std::int64_t now_us) {
  ring_ = {};
  oldest_ = held_count_ = 0;
  sum_ = 0;
  pending_ = repeats_ = lamp_ = false;
  enter(Phase::starting, now_us, start_up_us);
}

}  // namespace arkmesh::emulator
