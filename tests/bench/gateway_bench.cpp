// How long a message takes from bus to bus through two gateways, and what that costs, beside its parts in the same run:
// a hop of LCM and a hop of loopback TCP. gateway_bench SECONDS ARKMESH [ANOTHER ARKMESH]; a round of each by turns.
// Prints a table; a row is a program, a size and a rate. Run it alone: scripts/alone gateway_bench ...
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hal/bus.hpp"
#include "tests/support/processes/process.hpp"

namespace {

using namespace arkmesh;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Latencies = std::vector<double>;  // microseconds

constexpr int shark_port = 7846, roark_port = 7847, tcp_port = 7848, hop_port = 7849;

// Sizes with the rates at which processor time is measured.
constexpr std::pair<std::size_t, int> loads[] = {{100, 10'000}, {1'000, 10'000}, {10'000, 2'000}, {100'000, 500}};
constexpr int paced = 500;  // a second, for latencies

std::string url(int port) {
  return fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", port);
}

double percentile(Latencies& all, double part) {
  if (all.empty()) return 0;
  std::sort(all.begin(), all.end());
  return all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
}

void stamp(std::vector<std::byte>& message) {
  const auto now = Clock::now().time_since_epoch().count();
  std::memcpy(message.data(), &now, sizeof now);
}

double age_us(const std::byte* message) {
  Clock::rep sent;
  std::memcpy(&sent, message, sizeof sent);
  return static_cast<double>(Clock::now().time_since_epoch().count() - sent) * 1e-3;
}

// Calls `say` so many times a second, for so long; returns how often.
std::size_t at_rate(int rate, Clock::duration length, const std::function<void()>& say) {
  std::size_t said = 0;
  const auto begin = Clock::now();
  for (auto due = begin; due < begin + length; due += std::chrono::nanoseconds(1'000'000'000 / rate)) {
    if (due > Clock::now() + 50us) std::this_thread::sleep_until(due);
    say();
    ++said;
  }
  return said;
}

struct Heard {
  Latencies us;
  std::size_t said = 0;
};

// From one bus to another, or the same, heard in a thread of its own.
Heard over_bus(const std::string& from, const std::string& to, const std::string& channel, const std::string& heard_as,
               std::size_t size, int rate, Clock::duration length) {
  Heard heard;
  hal::Bus speaker(from), listener(to);
  bool warm = false;
  const auto subscription = listener.subscribe(heard_as, [&](std::string_view, std::span<const std::byte> bytes) {
    if (bytes.size() == size) heard.us.push_back(age_us(bytes.data()));
    warm |= bytes.size() != size;
  });
  const std::vector<std::byte> first(8);
  while (!warm) {
    speaker.publish(channel, first);
    listener.drain(20ms);
  }
  std::atomic<bool> over = false;
  std::thread ear([&] {
    while (!over) listener.drain(20ms);
    while (listener.drain(200ms) > 0) continue;
  });
  std::vector<std::byte> message(size);
  heard.said = at_rate(rate, length, [&] {
    stamp(message);
    speaker.publish(channel, message);
  });
  std::this_thread::sleep_for(100ms);
  over = true;
  ear.join();
  return heard;
}

// Over a TCP connection within this process.
Heard over_tcp(std::size_t size, Clock::duration length) {
  Heard heard;
  const int listening = socket(AF_INET, SOCK_STREAM, 0), speaker = socket(AF_INET, SOCK_STREAM, 0), on = 1;
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(tcp_port);
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const auto* address = reinterpret_cast<const sockaddr*>(&here);
  if (bind(listening, address, sizeof here) || listen(listening, 1) || connect(speaker, address, sizeof here))
    std::abort();
  const int listener = accept(listening, nullptr, nullptr);
  setsockopt(speaker, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  std::thread ear([&] {
    std::vector<std::byte> message(size);
    while (recv(listener, message.data(), size, MSG_WAITALL) == static_cast<ssize_t>(size))
      heard.us.push_back(age_us(message.data()));
  });
  std::vector<std::byte> message(size);
  heard.said = at_rate(paced, length, [&] {
    stamp(message);
    for (std::size_t done = 0; done < size;) {
      const ssize_t n = send(speaker, message.data() + done, size - done, 0);
      if (n <= 0) std::abort();
      done += static_cast<std::size_t>(n);
    }
  });
  shutdown(speaker, SHUT_WR);
  ear.join();
  for (const int socket : {listening, speaker, listener}) close(socket);
  return heard;
}

// Two gateways of one program.
struct Pair {
  tests::TemporaryFolder folder;
  std::unique_ptr<tests::Process> shark, roark;

  explicit Pair(const std::string& program) {
    shark = start(program, "shark", shark_port,
                  fmt::format("listen = \"127.0.0.1:{}\"\npeers = [{{lab = \"roark\"}}]", tcp_port + 2));
    roark = start(program, "roark", roark_port,
                  fmt::format("peers = [{{lab = \"shark\", connect = \"127.0.0.1:{}\"}}]", tcp_port + 2));
  }
  std::unique_ptr<tests::Process> start(const std::string& program, const std::string& lab, int port,
                                        const std::string& gateway) const {
    const auto file = folder.path() / (lab + ".toml");
    std::ofstream(file) << fmt::format(
        "[lab]\nname = \"{}\"\n[bus]\nurl = \"{}\"\n[shared]\nlabs = [\"roark\", \"shark\"]\n[gateway]\n"
        "exports = [\"newest\"]\nordered = [\"all\"]\n{}\n",
        lab, url(port), gateway);
    return std::make_unique<tests::Process>(program, std::vector<std::string>{"gateway", file.string()},
                                            folder.path() / (lab + ".txt"));
  }
  // Processor time of both so far.
  double cpu_s() const {
    double ticks = 0;
    for (const auto& process : {&shark, &roark}) {
      std::ifstream stat(fmt::format("/proc/{}/stat", (*process)->id()));
      std::string skipped;
      for (int i = 0; i < 13; ++i) stat >> skipped;
      double user = 0, system = 0;
      stat >> user >> system;
      ticks += user + system;
    }
    return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  }
  Heard carry(std::size_t size, int rate, Clock::duration length) const {
    return over_bus(url(shark_port), url(roark_port), "all", "shark/all", size, rate, length);
  }
};

struct Row {
  Latencies us;
  double cpu_us = 0;
  std::size_t said = 0, heard = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "gateway_bench SECONDS ARKMESH [ANOTHER ARKMESH]\n");
    return 2;
  }
  const auto length = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::atof(argv[1])));
  const std::vector<std::string> programs(argv + 2, argv + argc);
  std::map<std::size_t, Latencies> tcp, lcm;
  std::map<std::pair<std::string, std::size_t>, Row> rows;
  const auto add = [](Latencies& to, const Latencies& from) { to.insert(to.end(), from.begin(), from.end()); };
  constexpr int rounds = 3;
  for (int round = 0; round < rounds; ++round)
    for (const auto& [size, rate] : loads) {
      add(tcp[size], over_tcp(size, length).us);
      add(lcm[size], over_bus(url(hop_port), url(hop_port), "hop", "hop", size, paced, length).us);
      for (const std::string& program : programs) {
        const Pair pair(program);
        Row& row = rows[{program, size}];
        add(row.us, pair.carry(size, paced, length).us);
        const double before = pair.cpu_s();
        const Heard loaded = pair.carry(size, rate, length);
        row.cpu_us += 1e6 * (pair.cpu_s() - before);
        row.said += loaded.said;
        row.heard += loaded.us.size();
      }
    }
  for (const auto& [size, rate] : loads) {
    const double t = percentile(tcp[size], 0.5), l = percentile(lcm[size], 0.5);
    fmt::print("parts bytes {} tcp_us {:.1f} lcm_us {:.1f}\n", size, t, l);
    for (const std::string& program : programs) {
      Row& row = rows[{program, size}];
      fmt::print(
          "gateways bytes {} p50_us {:.1f} p99_us {:.1f} of_parts {:.2f} rate {} cpu_us {:.1f} lost {} program {}\n",
          size, percentile(row.us, 0.5), percentile(row.us, 0.99), percentile(row.us, 0.5) / (t + 2 * l), rate,
          row.cpu_us / static_cast<double>(std::max<std::size_t>(row.said, 1)), row.said - row.heard, program);
    }
  }
}
