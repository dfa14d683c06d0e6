// Arbitrary bytes at arbitrary times on the serial line of the emulator's overhead controller. Whatever comes, messages
// leave in order, one at a time, as long as they take; and the fine steps of time make no difference.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "emulator/ohc_device.hpp"

namespace {

using arkmesh::emulator::OhcDevice;
using arkmesh::sim_ode::Transmission;

void require(bool condition) {
  if (!condition) std::abort();
}

// Pairs of bytes: what to do and with what. `step_us` is how finely the device is asked what it sent; 0: only at the
// end.
std::vector<Transmission> run(const std::uint8_t* data, std::size_t size, std::int64_t step_us) {
  OhcDevice device;
  std::vector<Transmission> out;
  std::int64_t now = 1'900'000;
  const auto pass = [&](std::int64_t us) {
    for (std::int64_t until = now + us; now < until;) {
      now = step_us == 0 ? until : std::min(until, now + step_us);
      device.sent_until(now, out);
    }
  };
  for (std::size_t i = 0; i + 1 < size; i += 2) {
    const std::uint8_t what = data[i], with = data[i + 1];
    if (what < 0x60) {
      pass(260);
      device.receive(with, now);
    } else if (what < 0xE0) {
      // a packet with a right checksum, of which random bytes hardly ever have one
      std::uint8_t packet[OhcDevice::packet_bytes] = {0x55, static_cast<std::uint8_t>(what & 7), with};
      for (std::size_t k = 3; k + 1 < sizeof packet && i + k < size; ++k) packet[k] = data[i + k];
      for (std::size_t k = 0; k + 1 < sizeof packet; ++k) packet[sizeof packet - 1] ^= packet[k];
      for (const std::uint8_t byte : packet) {
        pass(260);
        device.receive(byte, now);
      }
    } else if (what < 0xF0) {
      pass(with * 1000);
    } else if (what < 0xF8) {
      device.unplug(now);
    } else if (!device.plugged()) {
      device.plug_in(now);
    }
    require(!device.on_air(now, now + 1) || device.on_air(now - 3, now + 1000));
  }
  pass(300'000);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 400) return 0;
  const std::vector<Transmission> coarse = run(data, size, 0), fine = run(data, size, 777);
  require(coarse.size() == fine.size());
  for (std::size_t k = 0; k < coarse.size(); ++k) {
    require(coarse[k].start_us == fine[k].start_us && coarse[k].clean == fine[k].clean &&
            coarse[k].message.data == fine[k].message.data);
    require(coarse[k].end_us - coarse[k].start_us == 4371);
    if (k > 0) require(coarse[k].start_us >= coarse[k - 1].end_us);
  }
  return 0;
}
