// An overhead controller's driver with a cable in a test's hand and time that only the test moves, a millisecond at a
// time.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <vector>

#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/overhead_controller.hpp"
#include "tests/support/kilobot/fake_cable.hpp"

namespace arkmesh::tests {

struct OverheadBench {
  using Ms = std::chrono::milliseconds;

  explicit OverheadBench(int robots = 10, hal::kilobot::OverheadSettings with = {}) : settings(with) {
    for (int i = 0; i < robots; ++i) info.robots.push_back(static_cast<hal::RobotId>(i));
  }
  // Through the controller's start-up and the stop that begins everything.
  void start() {
    run(settings.settle + Ms{50});
    cable->take();
  }
  void run(
      std::chrono::microseconds time, const std::function<void()>& each_ms = [] {}) {
    for (const auto end = now + time; now < end; now += Ms{1}) {
      cable->now = now;
      each_ms();
      controller.poll(now);
    }
  }
  void offer(hal::RobotId robot, std::uint8_t slot = 0, std::uint8_t kind = 1, std::uint16_t value = 5) {
    const hal::ToRobot message{robot, slot, kind, value};
    controller.offer({&message, 1});
  }

  hal::kilobot::OverheadSettings settings;
  hal::ArenaInfo info{hal::kilobot::kind_of(hal::kilobot::ark_layout, hal::WholeMessages::to_nobody)};
  hal::Counters counters;
  std::shared_ptr<FakeCable> cable = std::make_shared<FakeCable>();
  hal::kilobot::PacketPort line{std::make_unique<FakeStream>(cable), counters};
  hal::kilobot::OverheadController controller{info, line, settings, counters};
  hal::kilobot::TimePoint now{};
};

// The robots that a composite is for; none for packets of other kinds.
inline std::vector<hal::RobotId> robots_of(const hal::kilobot::Packet& packet) {
  std::vector<hal::RobotId> out;
  const auto type = static_cast<hal::kilobot::PacketType>(packet[1]);
  if (packet[11] != 0 || (type != hal::kilobot::PacketType::forward && type != hal::kilobot::PacketType::forward_once))
    return out;
  for (std::size_t at = 2; at < 11; at += 3) {
    const auto robot = static_cast<hal::RobotId>(packet[at] << 2 | packet[at + 1] >> 6);
    if (robot != 1023) out.push_back(robot);
  }
  return out;
}

}  // namespace arkmesh::tests
