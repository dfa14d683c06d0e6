#include "emulator/ohc_serial_port.hpp"

#include <algorithm>
#include <vector>

namespace arkmesh::emulator {

void OhcSerialPort::write(std::span<const std::uint8_t> bytes, std::int64_t now_us) {
  if (!plugged()) return counters_.add("serial.bytes_lost.unplugged", bytes.size());
  for (std::uint8_t byte : bytes) {
    if (free() == 0) {
      counters_.add("serial.bytes_lost.overflow");
      continue;
    }
    if (noise_ > 0 && chance_.uniform() < noise_) {
      byte ^= static_cast<std::uint8_t>(1 << chance_.below(8));
      counters_.add("serial.bytes_spoilt");
    }
    free_at_12_ = std::max(free_at_12_, 12 * now_us) + OhcDevice::byte_us_times_12;
    waiting_.push_back({free_at_12_ / 12, byte});
  }
}

void OhcSerialPort::deliver_until(std::int64_t until_us) {
  while (!waiting_.empty() && waiting_.front().at_us <= until_us) {
    device_.receive(waiting_.front().byte, waiting_.front().at_us);
    waiting_.pop_front();
  }
}

void OhcSerialPort::sent_until(std::int64_t until_us, std::vector<sim_ode::Transmission>& out) {
  deliver_until(until_us);
  const std::size_t before = out.size();
  device_.sent_until(until_us, out);
  if (!listener_) return;
  for (std::size_t k = before; k < out.size(); ++k) listener_(out[k]);
}

void OhcSerialPort::unplug(std::int64_t now_us) {
  if (!plugged()) return;
  deliver_until(now_us);
  counters_.add("serial.bytes_lost.unplugged", waiting_.size());
  waiting_.clear();
  device_.unplug(now_us);
}

void OhcSerialPort::plug_in(std::int64_t now_us) {
  if (!plugged()) device_.plug_in(now_us);
}

void OhcSerialPort::stall(std::int64_t lasts_us, std::int64_t now_us) {
  free_at_12_ = std::max(free_at_12_, 12 * (now_us + lasts_us));
}

void OhcSerialPort::garbage(std::size_t bytes, std::int64_t now_us) {
  std::vector<std::uint8_t> noise;
  for (std::size_t k = std::min(bytes, free()); k > 0; --k) noise.push_back(static_cast<std::uint8_t>(chance_.next()));
  counters_.add("serial.bytes_of_garbage", noise.size());
  write(noise, now_us);
}

}  // namespace arkmesh::emulator
