// Small emulators for tests.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::emulator {

inline constexpr hal::LabTime ms(std::int64_t n) {
  return std::chrono::milliseconds(n);
}

struct TestEmulator {
  std::string controller = "tests/emulator/controllers/shows.c";
  std::string poses = "-0.1, 0.0, 0.0, 0.1, 0.0, 1.5";  // two robots
  int robots = 2;
  std::string emulator = "ids = \"in_order\"";  // further lines of [emulator]
  std::string cameras = "[[emulator.camera]]\nwidth_px = 320\nheight_px = 240\nz_m = 0.8";
  std::string events;
  std::string arena;  // further lines of [arena.ode]

  std::string text() const {
    return fmt::format(
        "[emulator]\ncamera_port = 0\nohc_port = 0\ncontrol_port = 0\n{}\n{}\n{}\n[arena]\nwidth_m = 0.5\nheight_m = "
        "0.4\nrobots = {}\n"
        "[arena.ode]\ncontroller = \"{}/{}\"\nstart_poses = [{}]\n{}\n",
        emulator, cameras, events, robots, ARKMESH_SOURCE_DIR, controller, poses, arena);
  }
  Emulator make() const {
    const auto config = hal::Config::from_text(text(), "emulator.toml");
    Emulator out(config.root());
    config.refuse_unknown();
    return out;
  }
};

using Packet = std::array<std::uint8_t, OhcDevice::packet_bytes>;

// A packet of the overhead controller's protocol with its checksum.
inline Packet make_packet(std::uint8_t type, const std::vector<int>& bytes, std::uint8_t message_type = 0) {
  Packet out{};
  out[0] = 0x55;
  out[1] = type;
  std::size_t k = 2;
  for (int byte : bytes) out[k++] = static_cast<std::uint8_t>(byte);
  if (message_type != 0) out[11] = message_type;
  for (std::size_t i = 0; i + 1 < out.size(); ++i) out.back() ^= out[i];
  return out;
}

// The device has started up and says this for `span`.
inline void say(Emulator& emulator, const Packet& packet, hal::LabTime span) {
  emulator.write_serial(packet);
  emulator.advance_to(emulator.now() + span);
}

inline hal::Led led_of(const Emulator& emulator, int robot) {
  return emulator.truth()[static_cast<std::size_t>(robot)].led;
}

}  // namespace arkmesh::emulator
