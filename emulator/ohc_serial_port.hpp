// The serial line to the emulator's overhead controller: bytes written at once arrive one after the other at 38400
// baud, and may be spoilt on the way.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <utility>

#include "emulator/ohc_device.hpp"
#include "hal/random.hpp"

namespace arkmesh::emulator {

class OhcSerialPort final : public sim_ode::OverheadSource {
 public:
  // As much as a serial port's driver would hold; what comes on top must wait outside, as a writer to a real port does.
  static constexpr std::size_t max_waiting = 4096;

  explicit OhcSerialPort(std::uint64_t seed) : chance_(seed, "room/line") {}

  // Bytes that a host writes at `now_us`, which never decreases. Takes at most free() of them; the rest is lost and
  // counted.
  void write(std::span<const std::uint8_t> bytes, std::int64_t now_us);
  std::size_t free() const { return max_waiting - waiting_.size(); }

  // Faults. While unplugged, what is written is lost.
  void unplug(std::int64_t now_us);
  void plug_in(std::int64_t now_us);
  bool plugged() const { return device_.plugged(); }
  void garbage(std::size_t bytes, std::int64_t now_us);
  // Bytes that are written from now on arrive so much later at the earliest; none is lost.
  void stall(std::int64_t lasts_us, std::int64_t now_us);
  // From now on that share of the bytes comes with a wrong bit.
  void set_noise(double share) { noise_ = share; }

  // Hears each message that was on the air, in order, whether a robot heard it or not.
  void listen(std::function<void(const sim_ode::Transmission&)> listener) { listener_ = std::move(listener); }

  void sent_until(std::int64_t until_us, std::vector<sim_ode::Transmission>& out) override;
  bool on_air(std::int64_t from_us, std::int64_t to_us) const override { return device_.on_air(from_us, to_us); }

  const OhcDevice& device() const { return device_; }
  const hal::Counters& counters() const { return counters_; }

 private:
  struct Arriving {
    std::int64_t at_us;
    std::uint8_t byte;
  };
  void deliver_until(std::int64_t until_us);

  OhcDevice device_;
  std::deque<Arriving> waiting_;
  std::int64_t free_at_12_ = 0;  // when the line is free again, twelfths of a microsecond: a byte takes 3125 of them
  double noise_ = 0;
  hal::RandomStream chance_;
  std::function<void(const sim_ode::Transmission&)> listener_;
  hal::Counters counters_;
};

}  // namespace arkmesh::emulator
