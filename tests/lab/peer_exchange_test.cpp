// For whom a lab waits, until when, and when it gives up.
#include "lab/exchange/peer_exchange.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/arenas/messages.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using lab::LabState;
using lab::PeerWait;

namespace {

lab::RunConfig lab_a(std::vector<std::string> labs, lab::RunConfig::OnPeerLost then) {
  lab::RunConfig c;
  c.on_peer_lost = then;
  c.lab = c.owner = "a";
  c.labs = std::move(labs);
  for (const std::string& lab : c.labs) c.projections[lab];
  c.last_period = 100;
  c.patience = 600s;
  return c;
}

// Lab a at a boundary, and what its peers and its gateway tell it.
struct LabA {
  explicit LabA(std::vector<std::string> labs = {"a", "b"}, bool can_wait = true,
                lab::RunConfig::OnPeerLost then = lab::RunConfig::OnPeerLost::pause, bool with_labs = false)
      : config(lab_a(std::move(labs), then)), exchange(config, arena(can_wait, with_labs), 1, bus) {}

  static hal::ArenaInfo arena(bool can_wait, bool with_labs) {
    hal::ArenaInfo info;
    info.can_wait = can_wait;
    info.starts_with_labs = with_labs;
    return info;
  }

  void own(std::uint32_t period) {
    exchange.publish(state(period));
    bus.drain();
  }
  static LabState state(std::uint32_t period) {
    LabState s{.period = period};
    if (period == 0) s.settings["run.seed"] = "1";
    return s;
  }
  void world(const std::string& peer, std::vector<LabState> window, std::uint64_t run_id = 2, bool can_wait = true) {
    lab::WorldMessage m{.lab = peer, .run_id = run_id, .can_wait = can_wait, .window = std::move(window)};
    m.acks["a"] = {1, -1};
    bus.publish(peer + "/world", lab::to_message(m));
    bus.drain();
  }
  void status(const std::string& peer, const std::string& text = "running", std::int64_t run_id = 2,
              std::int8_t outcome = lab_status_t::open) {
    lab_status_t m{};
    m.outcome = static_cast<std::uint8_t>(outcome);
    m.lab = peer;
    m.nonce = run_id;
    m.state = text;
    bus.publish(peer + "/status", m);
    bus.drain();
  }
  // The gateway: which links are up.
  void links(const std::vector<std::string>& up) {
    peers_t m{};
    m.lab = "a";
    m.boot_id = 1;
    for (const std::string& lab : config.labs) {
      if (lab == "a") continue;
      m.peers.emplace_back();
      m.peers.back().lab = lab;
      m.peers.back().up = std::ranges::find(up, lab) != up.end();
    }
    m.n_peers = static_cast<std::int32_t>(m.peers.size());
    bus.publish(hal::channel::peers, m);
    bus.drain();
  }
  // Each second until `end` the gateway tells of links that are up, and `say` something more. Where that makes a give
  // up waiting for state `wanted`, it stops.
  template <class Say>
  PeerWait wait(std::chrono::microseconds end, std::uint32_t wanted, const std::vector<std::string>& up, Say say) {
    PeerWait wait;
    for (; wait.give_up.empty() && now < end; now += 1s) {
      exchange.set_now(now);
      links(up);
      say();
      wait = exchange.wait_for(wanted);
    }
    return wait;
  }

  // What is lost at `end`, with all links up until then.
  PeerWait lost(std::chrono::microseconds end) {
    PeerWait lost;
    for (; now < end; now += 1s) {
      exchange.set_now(now);
      links(config.labs);
      lost = exchange.look().lost;
    }
    return lost;
  }

  lab::RunConfig config;
  hal::Bus bus{"memq://"};
  lab::PeerExchange exchange;
  std::chrono::microseconds now{0};
};

}  // namespace

TEST_CASE("exchange: patience begins with a peer's first sign of life") {
  // A lab may be started an hour before its peers; one that runs and never joins is not waited for so long.
  LabA a;
  a.own(0);
  PeerWait wait = a.wait(1h, 0, {"b"}, [] {});
  CHECK(wait.give_up == "");
  CHECK(wait.text == "waiting for b: not started yet, until it connects or the lab is stopped");
  wait = a.wait(1h + 300s, 0, {"b"}, [&] { a.status("b", "starting"); });
  CHECK(wait.give_up == "");
  CHECK(wait.text == "waiting for b: it is running, but has not joined this run (starting), for 301 s more");
  wait = a.wait(3h, 0, {"b"}, [&] { a.status("b", "starting"); });
  CHECK(wait.give_up ==
        "gave up waiting for b after 600 s at period 0 of a (gate.patience_s): it is running, but has not joined this "
        "run (starting)");
  CHECK(a.now == 1h + 602s);
}

TEST_CASE("exchange: a peer that died before it joined may be started again") {
  LabA a;
  a.own(0);
  a.wait(300s, 0, {"b"}, [&] { a.status("b"); });
  CHECK(a.wait(1h, 0, {"b"}, [] {}).give_up == "");
  CHECK(a.wait(1h + 500s, 0, {"b"}, [&] { a.status("b", "starting", 3); }).give_up == "");
}

TEST_CASE("exchange: what counts, keeps a lab waiting; what only lives, does not") {
  LabA a;
  a.own(0);
  a.world("b", {LabA::state(0)});
  a.exchange.merge(0);
  a.own(1);
  CHECK(a.wait(1h, 1, {"b"}, [&] { a.world("b", {LabA::state(0)}); }).give_up == "");
  const PeerWait wait = a.wait(2h, 1, {"b"}, [&] { a.status("b"); });
  CHECK(wait.give_up == "gave up waiting for b after 600 s at period 0 of a (gate.patience_s): running");
  CHECK(a.now <= 1h + 602s);
}

TEST_CASE("exchange: five seconds of refused states end a wait, with the newest reason") {
  for (const bool bound : {false, true}) {
    CAPTURE(bound);
    LabA a;
    a.own(0);
    if (bound) {
      a.world("b", {LabA::state(0)});
      a.exchange.merge(0);
      a.own(1);
    }
    a.wait(100s, 1, {"b"}, [&] { a.status("b"); });
    const PeerWait wait = a.wait(1h, 1, {"b"}, [&] {
      a.status("b");
      a.world("b", {LabA::state(0), LabA::state(1), LabA::state(1)});
    });
    CHECK(wait.give_up ==
          "a refuses every state of b at period 0: its state 1 follows state 1; do both run the same version with the "
          "same settings?");
    CHECK(a.now == 106s);
  }
}

TEST_CASE("exchange: a message that an earlier run left behind ends nothing") {
  LabA a;
  a.own(0);
  const auto leftover = [&] { a.world("b", {LabA::state(3), LabA::state(2)}); };
  leftover();
  a.wait(60s, 0, {"b"}, [] {});
  leftover();
  CHECK(a.wait(120s, 0, {"b"}, [] {}).give_up == "");
  // nor do refused states that a counted one follows
  CHECK(a.wait(240s, 1, {"b"}, [&] {
           leftover();
           a.world("b", {LabA::state(0)});
         }).give_up == "");
}

TEST_CASE("exchange: a peer whose link is cut does not hide another one that is dead") {
  LabA a({"a", "b", "c"});
  a.own(0);
  for (const char* peer : {"b", "c"}) a.world(peer, {LabA::state(0)});
  a.exchange.merge(0);
  a.own(1);
  const PeerWait wait = a.wait(1h, 1, {"c"}, [] {});
  CHECK(wait.text.starts_with("waiting for b: link down, for "));
  CHECK(wait.give_up == "c is gone at period 0: silent for 6 s with its link up");
}

TEST_CASE("exchange: in free mode a lost peer is waited for, gone without, or the end") {
  using OnPeerLost = lab::RunConfig::OnPeerLost;
  for (const OnPeerLost then : {OnPeerLost::pause, OnPeerLost::go_on, OnPeerLost::end}) {
    LabA a({"a", "b"}, false, then);
    a.own(0);
    a.world("b", {LabA::state(0)});
    a.exchange.merge(0);
    CHECK(a.lost(5s).text == "");
    const PeerWait lost = a.lost(8s), long_lost = a.lost(602s);
    CHECK(lost.text == (then == OnPeerLost::pause ? "b: silent for 7 s with its link up, for 593 s more"
                                                  : "b: silent for 7 s with its link up"));
    if (then == OnPeerLost::end) {
      CHECK(lost.give_up ==
            "a has lost b at period 0: silent for 7 s with its link up; start all labs again (gate.on_peer_lost = "
            "\"end\")");
    } else {
      CHECK(lost.give_up == "");
      CHECK(long_lost.give_up == (then == OnPeerLost::go_on
                                      ? ""
                                      : "gave up waiting for b after 600 s at period 0 of a (gate.patience_s): silent "
                                        "for 601 s with its link up"));
    }
    a.world("b", {LabA::state(0)}, 3);  // started again
    CHECK(a.exchange.look().lost.text == "");
    CHECK(a.exchange.failure() == "");
    CHECK(a.exchange.counters()["gate.lost.b"] == 1);
  }
}

TEST_CASE("exchange: nobody waits for a peer that failed and says that all labs must start again") {
  for (const bool for_all : {true, false}) {
    LabA a({"a", "b"}, false);
    a.own(0);
    a.world("b", {LabA::state(0)});
    a.exchange.merge(0);
    const std::string said = for_all ? "failed: start all labs again: it was x and is y" : "failed: its camera is gone";
    a.status("b", said, 2, lab_status_t::failed);
    CHECK(a.lost(8s).give_up == (for_all ? "b is gone at period 0: " + said : ""));
  }
}

TEST_CASE("exchange: an arena that starts with labs passes no boundary without what labs say of it") {
  // In free mode, too. With gate.on_peer_lost = "go_on" it goes on once a peer is lost.
  using OnPeerLost = lab::RunConfig::OnPeerLost;
  for (const OnPeerLost then : {OnPeerLost::pause, OnPeerLost::go_on}) {
    LabA a({"a", "b"}, false, then, true);
    a.own(0);
    a.world("b", {LabA::state(0)});
    CHECK(a.exchange.may_merge(0));
    a.exchange.merge(0);
    a.own(1);
    CHECK_FALSE(a.exchange.may_merge(1));
    a.world("b", {LabA::state(1)});
    CHECK(a.exchange.may_merge(1));
    a.exchange.merge(1);
    a.own(2);
    a.lost(60s);
    CHECK(a.exchange.may_merge(2) == (then == OnPeerLost::go_on));
  }
}

TEST_CASE("exchange: who does not know our run is answered once a period, whatever run ids it makes up") {
  LabA a;
  a.own(0);
  int told = 0;
  const auto worlds = a.bus.subscribe("world", [&](auto, auto) { ++told; });
  const auto ask = [&](const char* peer, std::uint64_t run_id) {
    lab::WorldMessage m{.lab = peer, .run_id = run_id, .can_wait = true};
    m.acks["a"] = {run_id, -1};  // not ours
    a.bus.publish(std::string(peer) + "/world", lab::to_message(m));
    a.bus.drain();
    a.exchange.answer();
    a.bus.drain();
  };
  for (std::uint64_t i = 0; i < 100; ++i) ask("b", 1000 + i);
  for (std::uint64_t i = 0; i < 100; ++i) ask("stranger", 1000 + i);
  CHECK(told == 1);
  CHECK(a.exchange.counters()["world.taught"] == 100);
  CHECK(a.exchange.counters()["world.answered_before"] == 99);
  CHECK(a.exchange.counters()["world.refused.unknown_lab"] == 100);
  CHECK_FALSE(a.exchange.exchange_figures()["received"].contains("stranger"));
  a.exchange.set_now(a.config.period);
  ask("b", 1000);
  CHECK(told == 2);
}

TEST_CASE("exchange: all who do not know our run and ask at once get one answer") {
  LabA a({"a", "b", "c", "d"});
  a.own(0);
  int told = 0;
  const auto worlds = a.bus.subscribe("world", [&](auto, auto) { ++told; });
  for (const char* peer : {"b", "c", "d"}) {
    lab::WorldMessage m{.lab = peer, .run_id = 2, .can_wait = true};
    m.acks["a"] = {7, -1};  // not ours
    a.bus.publish(std::string(peer) + "/world", lab::to_message(m));
  }
  a.bus.drain();
  CHECK(told == 0);
  CHECK(a.exchange.answer());
  CHECK_FALSE(a.exchange.answer());
  a.bus.drain();
  CHECK(told == 1);
  CHECK(a.exchange.gate().message().acks.at("d").run_id == 2);
}

TEST_CASE("exchange: a lab that itself stood still has lost nobody") {
  // What its peers said meanwhile is only about to be heard.
  LabA a({"a", "b"}, false, lab::RunConfig::OnPeerLost::end);
  a.own(0);
  a.world("b", {LabA::state(0)});
  a.exchange.merge(0);
  a.lost(2s);
  a.now += 20s;
  CHECK(a.lost(24s).give_up == "");
  CHECK(a.lost(60s).give_up != "");
}
