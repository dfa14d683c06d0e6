// Two whole gateways, each on its lab's bus, with every fault of a network between them.
#include <doctest/doctest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/network/accounts.hpp"
#include "tests/support/network/raw_peer.hpp"
#include "tests/support/network/two_tcp_labs.hpp"
#include "tests/support/processes/run_delay.hpp"
#include "tests/support/processes/sanitized.hpp"

namespace arkmesh::gateway {
namespace {

using namespace tests;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

TEST_CASE("a reset connection comes back by itself") {
  // RST in the middle of traffic, ten times: both sides notice, reconnect and go on.
  TwoTcpLabs labs;
  for (int i = 0; i < 10; ++i) {
    labs.check_passage(std::to_string(i));
    labs.proxy->reset();
    REQUIRE(labs.until([&] { return labs.roark.count("session.opened") == static_cast<std::uint64_t>(i) + 2; }));
  }
  labs.check_passage("at last");
  CHECK(labs.proxy->counts().resets == 10);
  CHECK(labs.roark.count("session.closed.connection_lost") + labs.roark.count("session.closed.by_peer") == 10);
}

TEST_CASE("a black hole is noticed by both sides") {
  // Everything is swallowed, nothing is closed: heartbeats fail to come, and both links go down for it.
  TwoTcpLabs labs;
  labs.check_passage();
  labs.proxy->set({.swallow_to_target = true, .swallow_to_client = true});
  REQUIRE(labs.both(false));
  CHECK(labs.shark.link().stats().why == "nothing heard for 2 s");
  CHECK(labs.shark.count("session.closed.silent") == 1);
  CHECK(labs.proxy->counts().swallowed > 0);
  labs.shark.publish("world", "meanwhile 1");
  labs.shark.publish("world", "meanwhile 2");
  labs.proxy->set({});
  // Through the hole the proxy still accepts: those attempts end by the time for a hello.
  REQUIRE(labs.both(true));
  CHECK(labs.until([&] { return labs.roark.heard_last("shark/world", "meanwhile 2"); }));
}

TEST_CASE("a half-open connection is noticed by both sides") {
  // Only one direction is dead: the side that hears nothing closes, and the other learns it or notices by itself.
  for (const bool towards_shark : {true, false}) {
    CAPTURE(towards_shark);
    TwoTcpLabs labs;
    labs.check_passage();
    labs.proxy->set({.swallow_to_target = towards_shark, .swallow_to_client = !towards_shark});
    REQUIRE(labs.both(false));
    CHECK((towards_shark ? labs.shark : labs.roark).count("session.closed.silent") >= 1);
    labs.proxy->set({});
    labs.check_passage("mended");
  }
}

TEST_CASE("damaged bytes never become messages") {
  // With a bit flipped in each 3000th byte each way, what arrives is unchanged; damaged sessions are closed, counted,
  // replaced.
  TwoTcpLabs labs({.corrupt_every = 3000});
  std::vector<std::string> sent;
  REQUIRE(labs.until([&] {
    if (sent.size() < 200000 && labs.shark.up() && labs.shark.count("outbox.waiting.messages") < 3) {
      sent.push_back(std::to_string(sent.size()) + std::string(200 + sent.size() % 300, 'x'));
      labs.shark.publish("events", sent.back());
    }
    return labs.proxy->counts().corrupted >= 30 && labs.roark.heard.size() >= 100;
  }));
  // All of them, in order, each once.
  for (std::size_t i = 0; i < labs.roark.heard.size(); ++i) {
    REQUIRE(i < sent.size());
    CHECK(labs.roark.heard[i].first == "shark/events");
    REQUIRE(labs.roark.heard[i].second == sent[i]);
  }
  const auto bad = [](const TcpLab& lab) {
    return lab.count("session.closed.bad_header") + lab.count("session.closed.bad_checksum") +
           lab.node->counters()["session.closed.bad_header"] + lab.node->counters()["session.closed.bad_checksum"];
  };
  CHECK(bad(labs.roark) >= 10);
  CHECK(labs.roark.count("session.opened") >= 10);
  labs.proxy->set({});
  // Damage that is still on its way may end one more session, and what it carried: said until it is heard.
  int turn = 0;
  CHECK(labs.until([&] {
    if (turn++ % 100 == 0) {
      labs.shark.publish("world", "clean again");
      labs.roark.publish("world", "clean again");
    }
    return labs.shark.heard_last("roark/world", "clean again") && labs.roark.heard_last("shark/world", "clean again");
  }));
}

TEST_CASE("late, slow and sliced links carry everything") {
  // Delay, jitter, a rate limit and single-byte segments change when messages arrive, not what arrives.
  for (const Impairment& impairment :
       {Impairment{.delay = 20ms, .jitter = 10ms}, Impairment{.slice_bytes = 1}, Impairment{.bytes_per_s = 100'000},
        Impairment{.delay = 5ms, .bytes_per_s = 300'000, .slice_bytes = 3}}) {
    TwoTcpLabs labs(impairment);
    REQUIRE(labs.both(true));
    for (int i = 0; i < 50; ++i) labs.shark.publish("events", std::to_string(i) + std::string(500, 'x'));
    REQUIRE(labs.until([&] { return labs.roark.heard.size() == 50; }));
    for (int i = 0; i < 50; ++i)
      CHECK(labs.roark.heard[static_cast<std::size_t>(i)].second == std::to_string(i) + std::string(500, 'x'));
    CHECK(labs.roark.count("session.opened") == 1);
    if (impairment.slice_bytes > 0) CHECK(labs.proxy->counts().writes >= 25'000 / impairment.slice_bytes);
  }
}

TEST_CASE("on a slow link the newest goes first") {
  // A link of 50 kB/s is offered 5 MB/s of `latest`: the peer gets fewer, in order, and the last one, without the link
  // going down.
  TwoTcpLabs labs({.bytes_per_s = 50'000});
  REQUIRE(labs.both(true));
  const auto begun = Clock::now();
  for (int i = 0; i < 1000; ++i) {
    labs.shark.publish("world", std::to_string(i) + std::string(5000, 'x'));
    labs.shark.bus.drain();
    if (i % 50 == 0) labs.until([once = 0]() mutable { return once++ > 0; });
  }
  labs.shark.publish("world", "the last");
  REQUIRE(labs.until([&] { return labs.roark.heard_last("shark/world", "the last"); }));
  // Ten a second, and what was under way.
  CHECK(static_cast<double>(labs.roark.heard.size()) <
        100 + 10 * std::chrono::duration<double>(Clock::now() - begun).count());
  CHECK(labs.shark.count("outbox.replaced.world") + labs.roark.heard.size() == 1001);
  check_accounts(labs.shark.link().stats());
  CHECK(labs.shark.count("session.opened") == 1);
}

TEST_CASE("a refusing peer is tried with growing pauses, and told of once") {
  // While nobody listens the attempts become rarer and the reason is reported once; the first chance is taken.
  TwoTcpLabs labs;
  REQUIRE(labs.both(true));
  labs.proxy->refuse(true);
  REQUIRE(labs.both(false));
  const std::uint64_t before = labs.roark.count("session.failed.connect");
  const auto begun = Clock::now();
  std::uint64_t attempts = 0;
  REQUIRE(labs.until([&] {
    attempts = labs.roark.count("session.failed.connect") - before;
    return attempts >= 8;
  }));
  // no pause is shorter than 50 ms, and the first one is over or under way
  CHECK(Clock::now() - begun >= 50ms * (attempts - 2));
  CHECK(labs.roark.link().stats().why.find("Connection refused") != std::string::npos);
  labs.proxy->refuse(false);
  REQUIRE(labs.both(true));
}

TEST_CASE("either gateway may be killed and started again") {
  // A new gateway with a newer boot id finds the other again, whichever side it is.
  TwoTcpLabs labs;
  labs.check_passage("first");
  labs.start_roark();
  REQUIRE(labs.until([&] { return labs.shark.up() && labs.shark.link().stats().peer_boot_id == labs.boots; }));
  labs.check_passage("second");
  const std::string here = "127.0.0.1:" + std::to_string(labs.shark.node->listening().port());
  labs.start_shark(here);
  REQUIRE(labs.until([&] { return labs.roark.up() && labs.roark.link().stats().peer_boot_id == labs.boots; }));
  labs.check_passage("third");
}

// Resident memory of this process.
std::size_t resident_bytes() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

constexpr bool counts_memory = !tests::sanitized;  // sanitizers keep freed memory in quarantine

TEST_CASE("a stalled peer costs no more than its outbox") {
  // A peer that never reads is offered 200 MB: memory stays below the cap, everything dropped is counted, another peer
  // gets all of its messages, the stalled one is given up after its time, and stopping takes no time.
  for (const std::size_t size : {100u, 10'000u, 500'000u}) {
    CAPTURE(size);
    boost::asio::io_context io;
    TcpSettings settings = tcp_settings("shark", 100);
    settings.listen = "127.0.0.1:0";
    auto node = std::make_unique<Connections>(io, settings);
    auto stalled = node->link("roark"), healthy = node->link("lynx");
    for (Link* link : {stalled.get(), healthy.get()})
      link->start({.arrived = [](auto, auto) {}, .changed = [](auto, auto) {}});
    RawPeer roark(io, node->listening().port()), lynx(io, node->listening().port());
    Hello hello;
    hello.experiment = "dhtf";
    hello.boot_id = 7;
    hello.max_message_bytes = 1 << 20;
    hello.lab = "roark";
    roark.say(hello);
    hello.lab = "lynx";
    lynx.say(hello);
    lynx.listen();
    for (RawPeer* peer : {&roark, &lynx}) peer->beat();
    REQUIRE(run_until(io, [&] { return stalled->stats().up && healthy->stats().up; }));

    const std::vector<std::byte> message(size, std::byte{1});
    const std::size_t before = resident_bytes();
    std::size_t most = 0;
    std::uint64_t offered = 0, to_lynx = 0;
    auto beat = Clock::now();
    const std::size_t offers = 200'000'000 / (size + 1000);
    REQUIRE(run_until(io, [&] {
      for (std::size_t i = 0; i < 1'000'000 && offered < offers; i += size + 5000, ++offered)
        stalled->offer({"events", Delivery::ordered}, "events", message);
      if (lynx.messages.size() == to_lynx && to_lynx < 50) {
        healthy->offer({"events", Delivery::ordered}, "events", std::vector<std::byte>(10));
        ++to_lynx;
      }
      lynx.messages.resize(std::min<std::size_t>(lynx.messages.size(), 50));
      if (Clock::now() - beat > 100ms) {
        roark.beat();  // it lives, it only does not read
        lynx.beat();
        beat = Clock::now();
      }
      most = std::max(most, resident_bytes());
      return offered == offers && lynx.messages.size() == 50;
    }));
    const LinkStats stats = stalled->stats();
    CHECK(stats.counters["outbox.waiting.bytes"] <= settings.outbox_bytes);
    // Small messages fill it to the brim, the largest to within one message.
    CHECK(stats.counters["outbox.waiting.bytes"] > settings.outbox_bytes - size - 2 * Outbox::overhead_bytes);
    CHECK(stats.counters["outbox.accepted.events"] == offered);
    check_accounts(stats);
    if (counts_memory) CHECK(most - std::min(before, most) < settings.outbox_bytes * 11 / 10 + 2'000'000);

    REQUIRE(run_until(io, [&] {
      if (Clock::now() - beat > 100ms) {
        roark.beat();
        lynx.beat();
        beat = Clock::now();
      }
      return !stalled->stats().up;
    }));
    CHECK(stalled->stats().why == "the peer reads nothing for 5 s");
    CHECK(stalled->stats().counters["session.closed.does_not_read"] == 1);
    CHECK(healthy->stats().up);
    const tests::OwnTime stopping;
    stalled.reset();
    healthy.reset();
    node.reset();
    CHECK(stopping.passed() < 500ms);
  }
}

}  // namespace
}  // namespace arkmesh::gateway
