// How a peer is said to be, from what came of it.
#include "lab/exchange/peers.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

template <class Message>
std::vector<std::byte> encoded(const Message& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

using Now = lab::Peers::Now;

lab::RunConfig shark() {
  lab::RunConfig c;
  c.lab = c.owner = "shark";
  c.labs = {"roark", "shark"};
  c.last_period = 100;
  return c;
}

// Lab shark at boundary 1, and what its peer and its gateway tell it.
struct Shark {
  Shark() {
    for (std::uint32_t period : {0, 1}) gate.publish(state(period));
  }
  static lab::LabState state(std::uint32_t period) {
    lab::LabState s{.period = period};
    if (period == 0) s.settings["run.seed"] = "1";
    return s;
  }
  // State 0 of the peer counts, in its run 5.
  void join(Now now) {
    lab::WorldMessage m{.lab = "roark", .run_id = 5, .can_wait = true, .window = {state(0)}};
    m.acks["shark"] = {1, -1};
    REQUIRE(gate.hear("roark", m) == lab::PeriodGate::Heard::counted);
    peers.set_now(now);
    peers.note_counted("roark");
  }
  void status(Now now, const std::string& text = "running", std::int64_t run_id = 5) {
    lab_status_t m{};
    m.lab = "roark";
    m.nonce = run_id;
    m.state = text;
    m.outcome = text.starts_with("failed")    ? lab_status_t::failed
                : text.starts_with("stopped") ? lab_status_t::stopped
                                              : lab_status_t::open;
    hear_status("roark", encoded(m), now);
  }
  void hear_status(const std::string& lab, const std::vector<std::byte>& bytes, Now now) {
    peers.set_now(now);
    peers.hear_status(lab, bytes);
  }
  void links(Now now, bool up, std::int64_t boot_id = 1, const std::string& lab = "shark") {
    peers_t m{};
    m.lab = lab;
    m.boot_id = boot_id;
    m.peers.resize(1);
    m.peers[0].lab = "roark";
    m.peers[0].up = up;
    m.peers[0].why = up ? "connected" : "connection refused";
    m.n_peers = 1;
    peers.set_now(now);
    peers.hear_peers(encoded(m));
  }
  // How the peer is, without how long it is waited for.
  std::string is(Now now) {
    peers.set_now(now);
    const std::string text = peers.wait_for(1).text, begin = "waiting for roark: ";
    REQUIRE(text.starts_with(begin));
    return text.substr(begin.size(), std::min(text.find(", for "), text.find(", until ")) - begin.size());
  }

  lab::RunConfig config = shark();
  lab::PeriodGate gate{{.lab = "shark", .labs = config.labs, .last_period = 100}};
  lab::Peers peers{config, true, gate};
};

const std::string cut = "link down (connection refused)";
const std::string no_gateway = "the gateway of shark is silent; start it with: arkmesh gateway";

}  // namespace

TEST_CASE("dead means: link up and no status for five seconds") {
  // Proves rule 8 for a peer that was alive in this run.
  for (const bool joined : {true, false}) {
    CAPTURE(joined);
    Shark s;
    CHECK(s.is(0s) == no_gateway);
    s.links(0s, true);
    CHECK(s.is(0s) == "not started yet");
    if (joined) s.join(1s);
    s.status(1s);
    for (auto t = 1s; t <= 6s; t += 1s) s.links(t, true);
    // not of this run: it has not started yet
    CHECK(s.is(6s) == (joined ? "running" : "it is running, but has not joined this run (running)"));
    CHECK(s.is(6s + 1us) == (joined ? "silent for 5 s with its link up" : "not started yet"));
    CHECK(s.peers.wait_for(1).give_up == (joined ? "roark is gone at period 0: silent for 5 s with its link up" : ""));
  }
}

TEST_CASE("a peer that dies before its first status came is dead too") {
  // Proves that a state that counts is a sign of life, and that its lack is noticed: a fast run is over before the next
  // status.
  Shark s;
  for (auto t = 0s; t <= 7s; t += 1s) s.links(t, true);
  s.join(7s);
  for (auto t = 8s; t <= 12s; t += 1s) s.links(t, true);
  s.links(12s, true);
  CHECK(s.is(12s) == "running");
  CHECK(s.is(12s + 1us) == "silent for 5 s with its link up");
}

TEST_CASE("a free lab has lost a peer at once that says its operator stopped it") {
  // And not 5 s later, in which robots would walk on; it is back when it speaks of a run that goes on.
  Shark s;
  s.join(1s);
  s.links(1s, true);
  s.status(1s);
  CHECK(s.peers.look().lost.text.empty());
  s.status(1100ms, "stopped by the operator");
  CHECK(s.peers.look().lost.text.find("roark: stopped by the operator") == 0);
  CHECK(s.peers.counters()["gate.lost.roark"] == 1);
  s.status(1200ms);
  CHECK(s.peers.look().lost.text.empty());
}

TEST_CASE("who ends because a peer is over says whether an operator stopped that") {
  // Proves rows of state and outcome: a lab stops with its stopped peer, and fails with one that failed.
  for (const std::string said : {"stopped by the operator", "failed: no camera"}) {
    Shark s;
    s.join(1s);
    s.links(1s, true);
    s.status(1s);
    CHECK_FALSE(s.peers.wait_for(1).stopped);
    s.status(2s, said);
    const lab::PeerWait wait = s.peers.wait_for(1);
    CHECK(wait.give_up == "roark is gone at period 0: " + said);
    CHECK(wait.stopped == (said == "stopped by the operator"));
  }
}

TEST_CASE("labs that wait for each other do not quote each other's quotations") {
  Shark joined, other;
  for (Shark* s : {&joined, &other}) {
    s->links(0s, true);
    if (s == &joined) s->join(0s);
    s->status(0s, "waiting for shark: waiting for roark: running, for 600 s more");
  }
  CHECK(joined.is(1s) == "waiting for shark");
  CHECK(other.is(1s) == "it is running, but has not joined this run (waiting for shark)");
  joined.status(0s, "waiting for \x1b[2Jshark");
  CHECK(joined.is(1s) == "waiting for ?[2Jshark");
  joined.status(0s, "failed: roark failed at period 3: no camera");
  CHECK(joined.is(1s) == "failed: roark failed at period 3: no camera");
}

TEST_CASE("a cut link is waited for, and what comes after it counts anew") {
  // Proves that a peer is not called dead because its link was down for long.
  Shark s;
  s.links(0s, true);
  s.join(0s);
  s.status(0s);
  s.links(1s, false);
  s.links(29s, false);
  CHECK(s.is(30s) == cut);
  s.links(31s, true);
  CHECK(s.is(31s) == "running");
  for (auto t = 32s; t <= 37s; t += 1s) s.links(t, true);
  CHECK(s.is(37s) == "silent for 6 s with its link up");
}

TEST_CASE("a gateway that was killed and came back does not make its peers dead") {
  // Proves that old knowledge about links is void after a silence or a new boot id.
  Shark s;
  s.links(0s, true, 1);
  s.join(0s);
  s.status(0s);
  CHECK(s.is(4s) == no_gateway);
  s.links(20s, true, 2);
  CHECK(s.is(20s) == "running");
  s.status(21s);
  s.links(22s, true, 3);
  CHECK(s.is(22s) == "running");
}

TEST_CASE("a gateway that is silent because the network is gone is not told to be started") {
  // The bus counts what it could not send; when it sends again, the gateway is what is silent.
  Shark s;
  s.links(0s, true);
  s.peers.note_unsent(0);
  s.join(0s);
  s.status(0s);
  CHECK(s.is(4s) == no_gateway);
  s.peers.note_unsent(3);
  CHECK(s.is(5s) == "the network of shark is gone: its bus could not send 3 messages");
  s.peers.note_unsent(3);
  CHECK(s.is(8s) == no_gateway);
}

TEST_CASE("statuses of another run and messages about other labs are refused and counted") {
  // Proves that leftovers cannot end a run.
  Shark s;
  const auto count = [&](std::string_view name) { return s.peers.counters()[name]; };
  s.links(0s, true);
  s.join(0s);
  s.status(0s);
  s.status(1s, "failed: disk on fire", 6);
  CHECK(s.is(1s) == "running");
  CHECK(count("status.refused.other_run") == 1);
  s.links(1s, false, 1, "lynx");
  CHECK(count("peers.refused.other_name") == 1);
  CHECK(s.is(1s) == "running");
  s.status(2s, "failed: disk on fire");
  CHECK(s.is(2s) == "failed: disk on fire");
  const std::vector<std::byte> garbage(7);
  s.hear_status("roark", garbage, 2s);
  s.hear_status("lynx", garbage, 2s);
  s.peers.hear_peers(garbage);
  CHECK(count("status.refused.fingerprint") + count("status.refused.truncated") == 1);
  CHECK(count("status.refused.unknown_lab") == 1);
}
