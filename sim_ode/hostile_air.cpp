#include "sim_ode/hostile_air.hpp"

#include <algorithm>
#include <tuple>

namespace arkmesh::sim_ode {

Message HostileAir::message() {
  Message out;
  const auto byte = [&] { return static_cast<std::uint8_t>(chance_.below(256)); };
  if (known_.empty() || chance_.below(2) == 0) {
    for (std::uint8_t& each : out.data) each = byte();
    out.type = static_cast<std::uint8_t>(chance_.below(chance_.below(2) == 0 ? 8 : 128));
    return hal::kilobot::with_crc(out);
  }
  out = known_[chance_.below(known_.size())];
  for (std::uint64_t changes = 1 + chance_.below(3); changes > 0; --changes) {
    // the type is the tenth
    const std::uint64_t at = chance_.below(10);
    constexpr std::uint8_t ends[] = {0, 1, 0x7F, 0x80, 0xFF};
    const std::uint8_t value = chance_.below(2) == 0 ? ends[chance_.below(std::size(ends))] : byte();
    (at == 9 ? out.type : out.data[at]) = at == 9 ? value & 0x7F : value;
  }
  return hal::kilobot::with_crc(out);
}

void HostileAir::add(int robots, std::vector<Reception>& heard) {
  for (const Reception& one : heard) {
    if (known_.size() < 64)
      known_.push_back(one.message);
    else if (chance_.below(8) == 0)
      known_[chance_.below(known_.size())] = one.message;
  }
  for (int robot = 0; robot < robots; ++robot) {
    if (chance_.below(4) != 0) continue;
    const auto reading = [&] { return static_cast<std::int16_t>(chance_.below(1024)); };
    Reception one{.robot = robot,
                  .at_us = static_cast<std::uint32_t>(chance_.below(tick_us)),
                  .low_gain = reading(),
                  .high_gain = reading()};
    one.message = message();
    heard.push_back(one);
  }
  std::ranges::stable_sort(heard, {}, [](const Reception& one) { return std::tuple(one.robot, one.at_us); });
}

}  // namespace arkmesh::sim_ode
