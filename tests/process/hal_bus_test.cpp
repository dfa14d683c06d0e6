// The bus over multicast on this machine, on ports of this test's own. Everything that needs no network: tests/hal.
#include <doctest/doctest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

#include "hal/bus.hpp"
#include "hal/tap.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace arkmesh::hal;
using namespace std::chrono_literals;

TEST_CASE("a burst over the network arrives whole and in order") {
  // 500 messages wait at once, far beyond LCM's default queue of 30; then one of 1 MB, in many packets.
  Bus from("udpm://239.255.76.67:7810?ttl=0"), to("udpm://239.255.76.67:7810?ttl=0");
  std::vector<std::size_t> sizes;
  const auto subscription =
      to.subscribe("test/.*", [&](auto, std::span<const std::byte> bytes) { sizes.push_back(bytes.size()); });
  std::vector<std::size_t> expected;
  for (std::size_t i = 0; i < 500; ++i) expected.push_back(1000 + i);
  expected.push_back(1'000'000);
  for (std::size_t size : expected) from.publish("test/x", std::vector<std::byte>(size));
  CHECK(tests::eventually(20s, [&] {
    to.drain(10ms);
    return sizes.size() >= expected.size();
  }));
  CHECK(sizes == expected);
  CHECK(from.counters().all().empty());
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
  CHECK(bus.drain(20s) == 1);
  CHECK(std::chrono::steady_clock::now() - published < 10s);
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
  CHECK(tests::eventually(20s, [&] {
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
  if (said == "no namespace") {
    MESSAGE("not checked: this user may not make a network namespace");
    return;
  }
  CHECK(said ==
        "bus udpm://239.255.76.67:7813?ttl=0: this machine has no multicast route; make one with: ip link set lo up; "
        "ip route add "
        "224.0.0.0/4 dev lo");
}
