// Decides which states of all labs are merged at which boundary. Counts what peers have said; never talks to anybody,
// never waits and knows no wall clock. Strict when every arena can wait: boundary k merges exactly the states max(0, k
// - slack), whatever the network did. Free as soon as one arena cannot: boundary k merges the newest states at or
// before k - slack. There a lab that can wait does so, for states k - slack of the arenas that cannot.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "lab/exchange/exchange.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/exchange/state_rules.hpp"
#include "lab/exchange/world_message.hpp"

namespace arkmesh::lab {

class PeriodGate {
 public:
  enum class Mode { undecided, strict, free };  // undecided until the states 0 of all labs are there

  struct Options {
    std::string lab;
    std::vector<std::string> labs;  // all, own included
    std::uint32_t slack = 0;        // 0..8
    std::uint32_t last_period = 0;  // K, by the settings
    std::uint64_t run_id = 1;       // of this lab and run, never 0
    bool can_wait = true;
    std::uint32_t window = 0;  // own states per message; 0 means window_of(slack)
    Exchange exchange = {};
    // A payload stays in messages until confirm() has told of it, and not only until all peers have received it.
    bool until_confirmed = false;
  };

  explicit PeriodGate(Options options);

  // Peers' states that cannot be true by these rules are refused from now on. Before own state 0 none counts anyway.
  void set_rules(StateRules rules) { rules_ = std::move(rules); }

  // --- own side ---
  // Why peers would refuse the own state of the next period, by our own rules; none when they would not.
  std::optional<Refusal> own_refusal(const LabState& own) const;
  // The own state of the next period: 0, 1, 2, ... Never changed afterwards.
  void publish(LabState own);
  std::int64_t published() const { return published_; }  // -1 before state 0
  // Free mode: what became so before the next boundary; a state of that. Part of messages until it is published.
  void publish_early(LabState event);
  // Payloads made at boundaries to this one need no further telling.
  void confirm(std::int64_t period) { confirmed_ = std::max(confirmed_, period); }
  // Boundary `period` becomes the last one.
  void finish_at(std::uint32_t period) { last_period_ = period; }
  std::uint32_t last_period() const { return last_period_; }
  // What to publish on `world` now.
  WorldMessage message() const;

  // --- peers ---
  enum class Heard {
    counted,    // its states count (all of them, or those not yet known)
    taught,     // it does not know our run id yet; learnt its run id, nothing else
    refused,    // cannot be true or is not for us; changed nothing; the reason is counted
    restarted,  // strict: a peer whose states count began anew: its run is another one. Free: that counts instead
    different,  // its settings differ: see difference()
  };
  // `origin` is the lab that the channel name tells. Reasons go to counters() as "world.refused.<why>".
  Heard hear(std::string_view origin, const std::shared_ptr<const WorldMessage>& message);
  Heard hear(std::string_view origin, WorldMessage message) {
    return hear(origin, std::make_shared<const WorldMessage>(std::move(message)));
  }
  const std::string& difference() const { return difference_; }
  // What was wrong with the message refused last, for people.
  const std::string& newest_refusal() const { return newest_refusal_; }

  Mode mode() const { return mode_; }
  // The period of the states that boundary k merges, the newest until then in free mode.
  std::uint32_t wanted(std::uint32_t k) const { return k > options_.slack ? k - options_.slack : 0; }
  // The states that boundary k merges are there.
  bool may_merge(std::uint32_t k) const;
  // The states to merge at boundary k, ascending by lab, own included. Call once per boundary, in order, when
  // may_merge(k). Counts late and skipped states in free mode.
  std::vector<MergedState> merge(std::uint32_t k);
  // Free mode, for a lab that can wait: every real-time arena has sent state k - slack, so that boundary k merges that.
  bool has_real_time_states(std::uint32_t k) const;
  // States `period` of every peer have been received (strict: and all before).
  bool received_from_all(std::uint32_t period) const;
  // The newest own period that every peer has told to have; INT64_MAX without peers.
  std::int64_t acknowledged() const;

  // --- about one peer ---
  // Its state for our period `period` has been received (strict: and all before).
  bool has(std::string_view peer, std::uint32_t period) const { return has(peers_.find(peer)->second, period); }
  std::int64_t received(std::string_view peer) const;  // highest period received (strict: without gap); -1 none
  bool bound(std::string_view peer) const;             // its states count
  bool done(std::string_view peer) const;              // its newest state is its last
  // Free mode: our boundary that merges the last state of a peer that is done, with slack 0; -1 before it is done.
  std::int64_t ended_at(std::string_view peer) const;
  bool acknowledged(std::string_view peer, std::uint32_t period) const;
  const LabState* newest(std::string_view peer) const;   // null before state 0
  const LabState* initial(std::string_view peer) const;  // its state 0, kept for the whole run; null before it came
  std::uint64_t run_id(std::string_view peer) const;  // of the run that counts; 0 before it is bound, or for a stranger
  const std::vector<std::string>& peers() const { return peer_names_; }
  bool knows(std::string_view lab) const { return peers_.contains(lab); }

  const hal::Counters& counters() const { return counters_; }

 private:
  struct Peer {
    std::uint64_t run_id = 0;                // as last heard
    std::vector<std::uint64_t> former_runs;  // of which nothing counts any more
    bool bound = false;
    bool can_wait = true;
    bool done = false;
    std::int64_t received = -1;
    std::int64_t acknowledged = -1;  // highest own period it has received
    std::int64_t applied = -1;       // period merged last
    std::int64_t ahead = 0;          // by how many periods, since one of us began in mid-run of the other
    std::map<std::uint32_t, KeptState> states;
    KeptState initial;                // state 0, once received >= 0
    std::optional<EarlyEvent> event;  // the newest
  };
  std::optional<Refusal> begin_anew(Peer& peer, const WorldMessage& message);
  static bool has(const Peer& peer, std::int64_t period) {
    return peer.received >= (period == 0 ? 0 : period + peer.ahead);
  }
  Heard refuse(const Refusal& refusal);
  Heard refuse(std::string_view why) { return refuse({why, std::string(why)}); }
  std::optional<Refusal> refusal(const Peer& peer, const WorldMessage& message) const;
  static std::optional<Refusal> payload_refusal(const LabState& state, std::int64_t& known);
  std::optional<Refusal> event_refusal(const Peer& peer, const WorldMessage& message) const;
  void leave_out_known(std::vector<LabState>& window) const;
  static bool apply_event(const Peer& peer, std::int64_t until, MergedState& merged);
  void accept_event(Peer& peer, const EarlyEvent& event);
  bool find_difference(std::string_view peer, const LabState& initial);
  void accept(Peer& peer, KeptState state);
  void decide_mode();
  // Free: a peer whose clock is ahead has gone on when this lab finishes, and is still heard.
  std::uint32_t newest_of_peers() const { return mode_ == Mode::free ? options_.last_period : last_period_; }
  std::size_t kept() const;

  Options options_;
  std::uint32_t last_period_;  // the settings', or where finish_at() put it
  std::optional<StateRules> rules_;
  std::vector<std::string> peer_names_;
  Mode mode_ = Mode::undecided;
  std::int64_t published_ = -1, confirmed_ = -1;
  KeptState initial_;                       // own state 0
  std::map<std::uint32_t, KeptState> own_;  // newest window
  std::optional<EarlyEvent> event_;         // of the next period
  std::map<std::string, Peer, std::less<>> peers_;
  std::string difference_, newest_refusal_;
  hal::Counters counters_;
};

}  // namespace arkmesh::lab
