// An overhead controller as its serial line and its light show it: bytes in, infrared messages out, byte by byte and
// microsecond by microsecond as the published firmware (kilolib ohc.c) was measured to behave. Pure: times are passed
// in; it never answers.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "hal/counters.hpp"
#include "hal/platforms/kilobot/message.hpp"
#include "sim_ode/simulated_arena.hpp"

namespace arkmesh::emulator {

class OhcDevice final : public sim_ode::OverheadSource {
 public:
  static constexpr std::size_t packet_bytes = 132;
  static constexpr std::int64_t byte_us_times_12 = 3125;  // a byte at 38400 baud lasts 10 bits, 260.4 us

  // Plugged in at `now_us`: it starts up for 2 s, keeping only the last packet of that time.
  explicit OhcDevice(std::int64_t now_us = 0) { plug_in(now_us); }

  // A byte whose stop bit comes at `at_us`. Times never decrease, here and in run_until().
  void receive(std::uint8_t byte, std::int64_t at_us);
  // Everything that happens by itself until then, that moment included.
  void run_until(std::int64_t until_us);
  // Loses power, and all it knew, until plug_in().
  void unplug(std::int64_t now_us);
  void plug_in(std::int64_t now_us);
  bool plugged() const { return phase_ != Phase::unplugged; }
  // What its own lamp shows to people.
  bool lamp() const { return lamp_; }

  void sent_until(std::int64_t until_us, std::vector<sim_ode::Transmission>& out) override;
  bool on_air(std::int64_t from_us, std::int64_t to_us) const override;

  // Packets by type, bytes lost while deaf, transmissions dropped because nobody asked for them.
  const hal::Counters& counters() const { return counters_; }

 private:
  using Message = hal::kilobot::Message;
  enum class Phase : std::uint8_t {
    unplugged,
    starting,
    idle,
    thinking,  // from the packet's last byte, or the end of a repetition, to the first pulse
    sending,   // one message, distorted by bytes that come meanwhile
    blinking,  // the lamp after a message
    burst,     // several messages with interrupts off: no byte is served
    burst_lamp
  };
  struct Span {
    std::int64_t from_us, to_us;
  };

  void push(std::uint8_t byte, std::int64_t at_us);
  void enter(Phase phase, std::int64_t now_us, std::int64_t lasts_us);
  void end_phase();
  void act(std::int64_t now_us);
  void send(const Message& message, std::int64_t start_us, bool clean);
  void begin_message(std::int64_t now_us);
  void begin_pages(std::int64_t now_us);
  void begin_positions(std::int64_t now_us);
  void end_burst(std::int64_t now_us);

  std::array<std::uint8_t, packet_bytes> ring_{};
  std::size_t oldest_ = 0;
  std::uint8_t sum_ = 0;                             // XOR of the ring
  std::array<std::uint8_t, packet_bytes> packet_{};  // the newest that was recognised
  bool pending_ = false;                             // and not yet acted on
  std::array<std::uint8_t, 3> held_{};  // bytes that wait for a deaf processor: two buffered, one in the shift register
  std::size_t held_count_ = 0;

  Phase phase_ = Phase::idle;
  std::int64_t end_us_ = 0;    // of the phase; never for idle and unplugged
  std::int64_t start_us_ = 0;  // of the message
  Message message_;
  bool repeats_ = false, clean_ = true, lamp_ = false;
  std::deque<sim_ode::Transmission> sent_;  // waits for sent_until(); ends may lie ahead within a burst
  std::deque<Span> lit_;                    // the latest ones
  hal::Counters counters_;
};

}  // namespace arkmesh::emulator
