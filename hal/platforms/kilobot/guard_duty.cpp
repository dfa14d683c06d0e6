// What the process of StandGuard does.
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <exception>
#include <memory>
#include <optional>

#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/overhead_controller.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds speaks_for = 60s;             // robots may walk
constexpr std::chrono::milliseconds speaks_briefly_for = 2500ms;  // they stood when the program went
constexpr std::chrono::milliseconds lock_is_left_within = 2s;
constexpr std::chrono::milliseconds guards_stop_takes = 300ms;
constexpr std::chrono::milliseconds says_again_each = 100ms;

volatile std::sig_atomic_t wanted_elsewhere = 0;

// The last that was told; nothing when that is nothing.
std::optional<StandGuard::State> hear(int word) {
  std::optional<StandGuard::State> out;
  std::array<std::uint8_t, 3> bytes;
  for (;;) {
    const ssize_t n = ::recv(word, bytes.data(), bytes.size(), 0);
    if (n < 0 && errno == EINTR && wanted_elsewhere == 0) continue;
    if (n != std::ssize(bytes)) return out;
    out = {static_cast<FleetCommand::Kind>(bytes[0]), bytes[1] != 0, bytes[2] != 0};
  }
}

// The program that is gone may lose its lock a moment later than its voice.
std::unique_ptr<ByteStream> claim(const std::string& port) {
  for (const TimePoint until = machine_time().now() + lock_is_left_within;;) try {
      return claim_byte_stream(port, std::string(StandGuard::process_name) + ", for a program that is gone");
    } catch (const PortError&) {
      if (machine_time().now() >= until) throw;
      machine_time().wait_until(machine_time().now() + 10ms);
    }
}

// The controller may start anew when its port opens, or not: it is told at once, and again and again.
void speak(const std::string& port, FleetCommand::Kind wanted, std::chrono::milliseconds lasts) {
  ArenaInfo info{model_of(ark_layout, WholeMessages::to_nobody)};  // it says what all robots understand
  Counters counters;
  PacketPort line(claim(port), counters);
  OverheadController controller(info, line, {.again_after = says_again_each, .settle = 0us}, counters);
  controller.command({.kind = wanted});
  WallTime& time = machine_time();
  for (const TimePoint until = time.now() + lasts; wanted_elsewhere == 0 && time.now() < until;) {
    controller.poll(time.now());
    controller.urge(time.now());
    time.wait_until(std::min(controller.due(time.now()), until));
  }
  controller.stop_sending(time.now());
  const TimePoint until = time.now() + guards_stop_takes;
  while (line.is_open() && !controller.is_silent(time.now()) && time.now() < until) {
    controller.poll(time.now());
    time.wait_until(controller.due(time.now()));
  }
}

}  // namespace

int stand_guard(const std::string& port, int word) {
  struct sigaction leave {};
  leave.sa_handler = [](int) { wanted_elsewhere = 1; };
  ::sigaction(SIGTERM, &leave, nullptr);
  const auto state = hear(word);
  if (!state || (state->ended && state->all_stand)) return 0;
  try {
    speak(port, state->wanted, state->all_stand ? speaks_briefly_for : speaks_for);
  } catch (const std::exception&) {
    return 1;  // somebody else has the port, and robots in his charge
  }
  return 0;
}

}  // namespace arkmesh::hal::kilobot
