// Labs while somebody floods their bus.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "hal/arenas/messages.hpp"
#include "lab/operator/operator_message.hpp"
#include "lab/result.hpp"
#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/lcm_datagrams.hpp"
#include "tests/support/network/two_hosts.hpp"
#include "tests/support/processes/sanitized.hpp"

namespace {

using namespace arkmesh;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

// Of a process's memory.
std::size_t memory_kb(pid_t process) {
  const std::string status = read_file(fmt::format("/proc/{}/status", process));
  const auto at = status.find("VmRSS:");
  return at == std::string::npos ? 0 : std::stoul(status.substr(at + 6));
}

}  // namespace

TEST_CASE("labs are not hurt by a flood of another host, nor by forged fragments of their own") {
  // The flood forges every channel that a lab or gateway listens to, from before their start to their end: they start,
  // do not grow, have the hash of an undisturbed run, and count what they refused.
  const TwoHosts hosts;
  const Inside inside(hosts.lab_host());
  constexpr int port = 7822;
  LabProcesses labs({.overrides = {"run.duration_s=100"}, .first_port = port});
  std::atomic<std::uint64_t> sent = 0;
  const UdpSender stranger(hosts.stranger_host(), "10.9.0.2"), local(hosts.lab_host(), "10.9.0.1");
  std::jthread flood([&](const std::stop_token& over) {
    fleet_command_t pause{};
    pause.command = fleet_command_t::pause;
    std::string command(static_cast<std::size_t>(pause.getEncodedSize()), '\0');
    pause.encode(command.data(), 0, static_cast<int>(command.size()));
    std::vector<std::vector<std::byte>> forged;
    for (const char* channel : {"status", "peers", "poses", "roark/world"})
      forged.push_back(short_datagram(channel, std::string(500, 'x')));
    forged.push_back(short_datagram(lab::operator_channel, command));
    forged.push_back(fragment({.size = 1000, .offset = 0xffffffff - 299, .number = 1, .bytes = std::string(301, 'x')}));
    forged.push_back(fragment({.channel = "poses", .size = 1 << 28, .bytes = "x"}));
    std::uint32_t sequence = 0;
    while (!over.stop_requested()) {
      for (const auto& datagram : forged) {
        stranger.send(datagram, "239.255.76.67", port);
        stranger.send(datagram, "10.9.0.1", port);
        sent += 2;
      }
      // From this machine fragments only: who is on it may speak.
      local.send(
          fragment({.channel = "poses", .sequence = ++sequence, .size = 1 << 20, .bytes = std::string(1000, 'x')}),
          "239.255.76.67", port);
      local.send(forged[forged.size() - 1 - sequence % 2], "239.255.76.67", port);
      std::this_thread::sleep_for(1ms);
    }
  });
  labs.start();
  const bool begun = labs.reached("shark", 10, 300s);
  std::size_t least = 1 << 30, most = 0;
  while (begun && !labs.ended(0s)) {
    const std::size_t kb = memory_kb(labs.gateway("shark").id());
    least = std::min(least, kb), most = std::max(most, kb);
    labs.period("shark", 10ms);
  }
  flood.request_stop();
  flood.join();
  CAPTURE(labs.lab_output("shark"));
  CAPTURE(labs.gateway_output("shark"));
  CAPTURE(sent.load());
  REQUIRE(begun);
  CAPTURE(least);
  if (!sanitized) CHECK(most < least + 20'000);
  CHECK(labs.result("shark", "final_hash") == lab::hash_text(run_labs({.overrides = {"run.duration_s=100"}}).hash));
  const std::string counters = labs.result("shark", "counters");
  CHECK(counters.find("public_bus.refused.stranger") != std::string::npos);
  CHECK(counters.find("public_bus.refused.bad_fragment") != std::string::npos);
  CHECK(counters.find("public_bus.refused.too_long") != std::string::npos);
}
