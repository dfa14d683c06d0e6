// One hop over a lab's bus, from a sender's publish to a handler on an event loop: the bus's own receiver beside LCM's,
// turn by turn in one run. Prints latency when paced, CPU time of both sides, and what arrives of a burst.
#include <fmt/format.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "hal/bus/bus.hpp"
#include "hal/on_loop.hpp"

namespace {

using namespace arkmesh;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr const char* url = "udpm://239.255.76.67:7890?ttl=0&recv_buf_size=4194304";

// What calls `heard` with each message on the channel, once the loop runs.
struct Receiver {
  virtual ~Receiver() = default;
};
using Heard = std::function<void(std::span<const std::byte>)>;

struct BusReceiver : Receiver {
  BusReceiver(hal::EventLoop& loop, const Heard& heard)
      : bus(url),
        all(bus.subscribe("x", [heard](auto, auto bytes) { heard(bytes); })),
        readable(loop, bus.descriptor(), [this] { bus.drain(); }) {}
  hal::Bus bus;
  std::unique_ptr<hal::Bus::Subscription> all;
  hal::Readable readable;
};

// As the bus was before it had a receiver of its own.
struct LcmReceiver : Receiver {
  LcmReceiver(hal::EventLoop& loop, Heard to)
      : heard(std::move(to)), lcm(lcm_create(url)), readable(loop, subscribe(), [this] {
          for (int taken = 0; taken < 10'000 && waits(); ++taken) lcm_handle(lcm);
        }) {}
  ~LcmReceiver() override { lcm_destroy(lcm); }
  int subscribe() {
    const auto hear = [](const lcm_recv_buf_t* buffer, const char*, void* self) {
      static_cast<LcmReceiver*>(self)->heard({static_cast<const std::byte*>(buffer->data), buffer->data_size});
    };
    lcm_subscription_set_queue_capacity(lcm_subscribe(lcm, "x", hear, this), 0);
    return lcm_get_fileno(lcm);
  }
  bool waits() const {
    pollfd descriptor{lcm_get_fileno(lcm), POLLIN, 0};
    return poll(&descriptor, 1, 0) > 0;
  }
  Heard heard;
  lcm_t* lcm;
  hal::Readable readable;
};

// Publishes `count` messages from a process of its own, one each `pause`; each begins with the time of its sending.
pid_t send(std::size_t size, int count, std::chrono::nanoseconds pause) {
  const pid_t child = fork();
  if (child != 0) return child;
  hal::Bus bus(url);
  std::vector<std::byte> bytes(size);
  auto next = Clock::now() + 50ms;
  for (int i = 0; i < count; ++i, next += pause) {
    std::this_thread::sleep_until(next);
    const auto now = Clock::now().time_since_epoch().count();
    std::memcpy(bytes.data(), &now, sizeof now);
    bus.publish("x", bytes);
  }
  _exit(0);
}

double cpu_us() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto us = [](timeval t) { return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_usec); };
  return us(used.ru_utime) + us(used.ru_stime);
}

struct Measured {
  double p50_us = 0, p99_us = 0, cpu_us = 0;  // of one message, the receiver's
  double arrived = 0;                         // share
};

template <class Kind>
Measured measure(std::size_t size, int count, std::chrono::nanoseconds pause) {
  hal::EventLoop loop;
  std::vector<double> latencies;
  auto last = Clock::now();
  Kind receiver(loop, [&](std::span<const std::byte> bytes) {
    Clock::rep then = 0;
    std::memcpy(&then, bytes.data(), sizeof then);
    last = Clock::now();
    latencies.push_back(static_cast<double>(last.time_since_epoch().count() - then) * 1e-3);
  });
  const double before = cpu_us();
  const pid_t sender = send(size, count, pause);
  last = Clock::now();
  while (latencies.size() < static_cast<std::size_t>(count) && Clock::now() - last < 1s) loop.run_for(20ms);
  const double used = cpu_us() - before;
  waitpid(sender, nullptr, 0);
  if (latencies.empty()) return {};
  std::ranges::sort(latencies);
  const auto n = static_cast<double>(latencies.size());
  return {latencies[latencies.size() / 2], latencies[latencies.size() * 99 / 100], used / n, n / count};
}

}  // namespace

int main() {
  constexpr int rounds = 5;
  fmt::print("{:>8} {:>9} | {:>28} | {:>28}\n", "", "", "own receiver", "LCM's receiver");
  fmt::print("{:>8} {:>9} | {:>6} {:>7} {:>6} {:>6} | {:>6} {:>7} {:>6} {:>6}\n", "bytes", "rate/s", "p50us", "p99us",
             "CPUus", "got", "p50us", "p99us", "CPUus", "got");
  for (const std::size_t size : {100U, 1000U, 10'000U, 100'000U})
    for (const int rate : {20, 500, 5000}) {
      std::vector<Measured> own, lcm;
      for (int round = 0; round < rounds; ++round) {
        own.push_back(measure<BusReceiver>(size, std::max(rate, 100), 1'000'000'000ns / rate));
        lcm.push_back(measure<LcmReceiver>(size, std::max(rate, 100), 1'000'000'000ns / rate));
      }
      const auto median = [](std::vector<Measured> of, double Measured::*what) {
        std::ranges::sort(of, {}, what);
        return of[of.size() / 2].*what;
      };
      fmt::print("{:>8} {:>9}", size, rate);
      for (const auto& of : {own, lcm})
        fmt::print(" | {:>6.1f} {:>7.1f} {:>6.2f} {:>6.3f}", median(of, &Measured::p50_us),
                   median(of, &Measured::p99_us), median(of, &Measured::cpu_us), median(of, &Measured::arrived));
      fmt::print("\n");
      std::fflush(stdout);
    }
}
