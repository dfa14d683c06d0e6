// The bus over multicast on this machine, on ports of this test's own. Everything that needs no network: tests/hal.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "hal/bus/bus.hpp"
#include "hal/bus/tap.hpp"
#include "hal/record/event_log.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace arkmesh::hal;
using namespace std::chrono_literals;

TEST_CASE("a burst over the network arrives whole and in order") {
  // 500 messages wait at once; then one of 1 MB, in many packets.
  Bus from("udpm://239.255.76.67:7810?ttl=0"), to("udpm://239.255.76.67:7810?ttl=0");
  std::vector<std::size_t> sizes;
  const auto subscription =
      to.subscribe("test/.*", [&](auto, std::span<const std::byte> bytes) { sizes.push_back(bytes.size()); });
  std::vector<std::size_t> expected;
  for (std::size_t i = 0; i < 500; ++i) expected.push_back(1000 + i);
  expected.push_back(1'000'000);
  for (std::size_t size : expected) from.publish("test/x", std::vector<std::byte>(size));
  CHECK(tests::eventually(300s, [&] {
    to.drain(10ms);
    return sizes.size() >= expected.size();
  }));
  CHECK(sizes == expected);
  CHECK(from.counters().all().empty());
}

TEST_CASE("the bus and LCM's own programs understand each other on one port") {
  // Both ways, whole and in fragments: liblcm sends and the bus hears; the bus sends and liblcm's receiver and
  // lcm-logger hear, byte for byte.
  const std::string url = "udpm://239.255.76.67:7814?ttl=0&recv_buf_size=4194304";
  const std::unique_ptr<lcm_t, void (*)(lcm_t*)> lcm(lcm_create(url.c_str()), lcm_destroy);
  REQUIRE(lcm);
  const tests::TemporaryFolder folder;
  const auto log = folder.path() / "log.lcm";
  tests::Process logger("/usr/bin/lcm-logger", {"--lcm-url=" + url, "--flush-interval=1", log.string()},
                        folder.path() / "logger.txt");
  Bus bus(url);
  using Heard = std::vector<std::vector<std::byte>>;
  Heard sent, by_bus, by_lcm;
  for (std::size_t size : {0U, 100U, 65'487U, 65'494U, 65'495U, 100'000U, 1'000'000U}) {
    std::vector<std::byte>& bytes = sent.emplace_back(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 2'654'435'761U >> 13);
  }
  const auto from_lcm =
      bus.subscribe("lcm", [&](auto, auto bytes) { by_bus.emplace_back(bytes.begin(), bytes.end()); });
  lcm_subscribe(
      lcm.get(), "bus",
      [](const lcm_recv_buf_t* buffer, const char*, void* heard) {
        const auto* first = static_cast<const std::byte*>(buffer->data);
        static_cast<Heard*>(heard)->emplace_back(first, first + buffer->data_size);
      },
      &by_lcm);
  // The logger is there once it has written what was said.
  CHECK(tests::eventually(300s, [&] {
    bus.publish("begin", {});
    bus.drain(50ms);
    return std::filesystem::exists(log) && std::filesystem::file_size(log) > 0;
  }));
  for (const auto& bytes : sent) {
    lcm_publish(lcm.get(), "lcm", bytes.data(), static_cast<unsigned>(bytes.size()));
    bus.publish("bus", bytes);
    CHECK(tests::eventually(300s, [&] {
      bus.drain(5ms);
      pollfd waiting{lcm_get_fileno(lcm.get()), POLLIN, 0};
      while (poll(&waiting, 1, 0) == 1) lcm_handle(lcm.get());
      return by_bus.size() == by_lcm.size() && by_bus.size() == 1U + static_cast<std::size_t>(&bytes - sent.data());
    }));
  }
  CHECK(by_bus == sent);
  CHECK(by_lcm == sent);
  CHECK(bus.counters().all().empty());

  const auto logged = [&](const std::string& channel) {
    Heard heard;
    EventLogReader reader(log);
    while (const auto event = reader.next())
      if (event->channel == channel) heard.emplace_back(event->bytes.begin(), event->bytes.end());
    return heard;
  };
  CHECK(tests::eventually(300s, [&] {
    bus.publish("end", {});  // lcm-logger writes when it hears something
    bus.drain(50ms);
    return logged("bus").size() == sent.size();
  }));
  CHECK(logged("bus") == sent);
  CHECK(logged("lcm") == sent);
}

TEST_CASE("a bus that nobody listens to opens no port") {
  // LCM itself never opens one: only the bus's own receiver does, at the first subscription.
  const auto sockets_on_port = [] {
    std::ifstream table("/proc/net/udp");
    int count = 0;
    for (std::string line; std::getline(table, line);)
      count += line.find(fmt::format(":{:04X} ", 7815)) != std::string::npos;
    return count;
  };
  Bus bus("udpm://239.255.76.67:7815?ttl=0");
  bus.publish("x", std::vector<std::byte>(100'000));
  CHECK(sockets_on_port() == 0);
  const auto subscription = bus.subscribe("x", [](auto, auto) {});
  bus.publish("x", {});
  CHECK(bus.drain(300s) == 1);
  CHECK(sockets_on_port() == 1);
}

TEST_CASE("a full receive buffer is counted") {
  // Who is heard is lost then, and only as much as is missing.
  Bus from("udpm://239.255.76.67:7816?ttl=0"), to("udpm://239.255.76.67:7816?ttl=0&recv_buf_size=100000");
  std::uint64_t heard = 0;
  const auto subscription = to.subscribe("x", [&](auto, auto) { ++heard; });
  CHECK(to.counters().all().empty());
  for (int i = 0; i < 1000; ++i) from.publish("x", std::vector<std::byte>(1000));
  to.drain();
  const std::uint64_t lost = to.counters()["lost.receive_buffer_full"];
  CHECK(lost > 0);
  CHECK(heard + lost == 1000);
  CHECK(to.counters().all().size() == 1);
}

TEST_CASE("a handler's exception loses no message of the network") {
  // What was fetched with the message that it did not like comes at the next drain.
  Bus bus("udpm://239.255.76.67:7817?ttl=0");
  int heard = 0;
  const auto subscription = bus.subscribe("x", [&](auto, auto) {
    if (++heard == 1) throw std::runtime_error("no good");
  });
  for (int i = 0; i < 3; ++i) bus.publish("x", {});
  CHECK_THROWS_WITH(bus.drain(300s), "no good");
  CHECK(bus.drain() == 2);
}

TEST_CASE("drain waits no longer than asked") {
  // With nobody sending it returns after the wait, and at once when a message is there.
  Bus bus("udpm://239.255.76.67:7811?ttl=0");
  const auto subscription = bus.subscribe("x", [](auto, auto) {});
  const auto before = std::chrono::steady_clock::now();
  CHECK(bus.drain(30ms) == 0);
  CHECK(std::chrono::steady_clock::now() - before >= 29ms);
  bus.publish("x", {});
  const auto published = std::chrono::steady_clock::now();
  CHECK(bus.drain(300s) == 1);
  CHECK(std::chrono::steady_clock::now() - published < 250s);
}

TEST_CASE("a tap does not take in what it sent out") {
  // Multicast brings a sender its own messages; the lab hears its world once, although a pattern of its inputs matches
  // all names.
  Bus inside("memq://"), outside("udpm://239.255.76.67:7812?ttl=0"), other("udpm://239.255.76.67:7812?ttl=0");
  int own = 0, foreign = 0, seen_outside = 0;
  const auto a = inside.subscribe("world", [&](auto, auto) { ++own; });
  const auto b = inside.subscribe("roark/world", [&](auto, auto) { ++foreign; });
  const auto c = other.subscribe(".*world", [&](auto, auto) { ++seen_outside; });
  const Tap tap(inside, outside, {"[^/]+/.*"});
  for (int i = 0; i < 10; ++i) inside.publish("world", {});
  inside.drain();
  other.publish("roark/world", {});
  CHECK(tests::eventually(300s, [&] {
    outside.drain(5ms), inside.drain(), other.drain(5ms);
    return foreign == 1 && seen_outside == 11;
  }));
  CHECK(own == 10);
  CHECK(foreign == 1);
  CHECK(seen_outside == 11);
}

TEST_CASE("without a multicast route the bus says how to make one") {
  // In a network namespace of its own a process has none.
  int pipe_ends[2];
  REQUIRE(pipe(pipe_ends) == 0);
  const pid_t child = fork();
  if (child == 0) {
    std::string said = "no namespace";
    if (unshare(CLONE_NEWNET) == 0 || unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0) {
      try {
        Bus bus("udpm://239.255.76.67:7813?ttl=0");
        said = "no complaint";
      } catch (const std::runtime_error& error) {
        said = error.what();
      }
    }
    [[maybe_unused]] const ssize_t written = write(pipe_ends[1], said.data(), said.size());
    _exit(0);
  }
  close(pipe_ends[1]);
  std::string said(1000, '\0');
  const ssize_t length = read(pipe_ends[0], said.data(), said.size());
  close(pipe_ends[0]);
  waitpid(child, nullptr, 0);
  said.resize(static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  CHECK(said ==
        "bus udpm://239.255.76.67:7813?ttl=0: this machine has no multicast route; make one with: ip link set lo up; "
        "ip route add "
        "224.0.0.0/4 dev lo");
}
