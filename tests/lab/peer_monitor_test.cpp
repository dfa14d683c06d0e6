#include "lab/peer_monitor.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using lab::PeerMonitor;
using Life = PeerMonitor::Life;

namespace {

template <class Message>
std::vector<std::byte> encoded(const Message& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

struct Watch : PeerMonitor {
  Watch() : PeerMonitor("shark", {"roark"}) {}
  void status(Now now, const std::string& state = "running", std::int64_t run_id = 5, std::uint64_t bound = 5) {
    lab_status_t m{};
    m.lab = "roark";
    m.nonce = run_id;
    m.state = state;
    m.outcome = state.starts_with("failed") ? lab_status_t::failed : lab_status_t::open;
    hear_status("roark", bound, encoded(m), now);
  }
  void peers(Now now, bool up, std::int64_t boot_id = 1, const std::string& lab = "shark") {
    peers_t m{};
    m.lab = lab;
    m.boot_id = boot_id;
    m.peers.resize(1);
    m.peers[0].lab = "roark";
    m.peers[0].up = up;
    m.peers[0].why = up ? "connected" : "connection refused";
    m.n_peers = 1;
    hear_peers(encoded(m), now);
  }
};

}  // namespace

TEST_CASE("dead means: link up and no status for five seconds") {
  // Proves rule 8 for a peer that was alive in this run.
  Watch w;
  CHECK(w.life("roark", false, 0s) == Life::gateway_silent);
  w.peers(0s, true);
  CHECK(w.life("roark", false, 0s) == Life::unknown);
  w.status(1s);
  CHECK(w.life("roark", true, 1s) == Life::alive);
  for (auto t = 2s; t <= 6s; t += 1s) w.peers(t, true);
  CHECK(w.life("roark", true, 6s) == Life::alive);
  CHECK(w.life("roark", true, 6s + 1us) == Life::dead);
  CHECK(w.life("roark", false, 6s + 1us) == Life::unknown);  // not of this run: it has not started yet
}

TEST_CASE("a peer that dies before its first status came is dead too") {
  // Proves that a state that counts is a sign of life, and that its lack is noticed: a fast run is over before the next
  // status.
  Watch w;
  w.peers(0s, true);
  w.hear_state("roark", 7s);
  for (auto t = 1s; t <= 12s; t += 1s) w.peers(t, true);
  CHECK(w.life("roark", true, 12s) == Life::alive);
  CHECK(w.words("roark", true, 12s) == "running");
  CHECK(w.life("roark", true, 12s + 1us) == Life::dead);
}

TEST_CASE("labs that wait for each other do not quote each other's quotations") {
  Watch w;
  w.peers(0s, true);
  w.status(0s, "waiting for shark: waiting for roark: running, for 600 s more");
  CHECK(w.words("roark", true, 1s) == "waiting for shark");
  CHECK(w.words("roark", false, 1s) == "it runs, but has not joined this run (waiting for shark)");
  w.status(0s, "waiting for \x1b[2Jshark");
  CHECK(w.words("roark", true, 1s) == "waiting for ?[2Jshark");
  w.status(0s, "failed: roark failed at period 3: no camera");
  CHECK(w.words("roark", true, 1s) == "failed: roark failed at period 3: no camera");
}

TEST_CASE("a cut link is waited for, and what comes after it counts anew") {
  // Proves that a peer is not called dead because its link was down for long.
  Watch w;
  w.peers(0s, true);
  w.status(0s);
  w.peers(1s, false);
  w.peers(29s, false);
  CHECK(w.life("roark", true, 30s) == Life::link_down);
  CHECK(w.words("roark", true, 30s) == "link down (connection refused)");
  w.peers(31s, true);
  CHECK(w.life("roark", true, 31s) == Life::alive);
  for (auto t = 32s; t <= 37s; t += 1s) w.peers(t, true);
  CHECK(w.life("roark", true, 37s) == Life::dead);
}

TEST_CASE("a gateway that was killed and came back does not make its peers dead") {
  // Proves that old knowledge about links is void after a silence or a new boot id.
  Watch w;
  w.peers(0s, true, 1);
  w.status(0s);
  CHECK(w.life("roark", true, 4s) == Life::gateway_silent);
  w.peers(20s, true, 2);
  CHECK(w.life("roark", true, 20s) == Life::alive);
  w.status(21s);
  w.peers(22s, true, 3);
  CHECK(w.life("roark", true, 22s) == Life::alive);
}

TEST_CASE("statuses of another run and messages about other labs are refused and counted") {
  // Proves that leftovers cannot end a run.
  Watch w;
  w.peers(0s, true);
  w.status(0s);
  w.status(1s, "failed: disk on fire", 6);
  CHECK(w.life("roark", true, 1s) == Life::alive);
  CHECK(w.counters()["status.refused.other_run"] == 1);
  w.peers(1s, false, 1, "lynx");
  CHECK(w.counters()["peers.refused.other_name"] == 1);
  CHECK(w.life("roark", true, 1s) == Life::alive);
  w.status(2s, "failed: disk on fire");
  CHECK(w.life("roark", true, 2s) == Life::failed);
  CHECK(w.words("roark", true, 2s) == "failed: disk on fire");
  const std::vector<std::byte> garbage(7);
  w.hear_status("roark", 5, garbage, 2s);
  w.hear_peers(garbage, 2s);
  w.hear_status("lynx", 5, garbage, 2s);
  CHECK(w.counters()["status.refused.fingerprint"] + w.counters()["status.refused.truncated"] == 1);
  CHECK(w.counters()["status.refused.unknown_lab"] == 1);
}
