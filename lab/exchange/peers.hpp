// What a lab knows of its peers and what follows from it: which of them are alive, cut off or dead, for whom the lab
// waits or whom it has lost, and until when, and when it may leave. Sends nothing; the caller owns time.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/exchange/period_gate.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::lab {

struct PeerWait {
  std::string text;      // "waiting for roark: link down, for 590 s more"; empty when nobody is waited for
  std::string give_up;   // why nothing will come any more; empty when it still makes sense to wait
  bool stopped = false;  // that is because an operator stopped the peer
};

// What a look in free mode finds.
struct PeerLook {
  PeerWait lost;        // peers of which nothing counts any more, and whether that ends the run
  std::string silence;  // why robots are to stand still although no peer may be lost; empty when they may go
};

class Peers {
 public:
  using Now = std::chrono::microseconds;
  static constexpr Now status_limit{5'000'000};   // link up and no status for so long: dead
  static constexpr Now gateway_limit{3'000'000};  // no `peers` for so long: our own gateway is silent
  // What a lab says that failed and cannot come back into this world: its peers do not wait for it.
  static constexpr std::string_view all_again = "start all labs again:";

  // `gate` outlives it. `can_wait`: the own arena can.
  Peers(const RunConfig& config, bool can_wait, const PeriodGate& gate);

  // Time of the current step: to be set before all else.
  void set_now(Now now) { now_ = now; }
  Now now() const { return now_; }
  std::uint32_t period() const { return period_; }  // the boundary passed last

  // --- what came ---
  // `<peer>/status` and our gateway's `peers`, as they came; what is ill-formed, of another run or about others is
  // refused and counted. False: it was refused.
  bool hear_status(std::string_view peer, std::span<const std::byte> bytes);
  // ... or more than a gateway says, and not worth recording.
  bool hear_peers(std::span<const std::byte> bytes);
  // A state counted, of a peer of the gate. It is as much a sign of life as a status, which a fast run may not have
  // come to yet.
  void note_counted(std::string_view peer);
  void note_refused(std::string_view origin, std::string why);
  // The own state of the next boundary is published; boundary `period` is passed, with these states.
  void note_published() { boundary_ = now_; }
  void note_merged(std::uint32_t period, const std::vector<MergedState>& merged);

  // How many messages this lab's bus could not send so far: where the network has gone, the gateway seems silent.
  void note_unsent(std::uint64_t total) {
    if (total > std::exchange(unsent_, total)) unsent_at_ = now_;
  }

  // --- how peers are ---
  // Each peer gives signs of life, and of a run that is not over.
  bool all_met() const;

  // `wanted`: the period of the peers' states that the lab waits for since its last boundary. It gives up on a peer
  // that is gone, on one whose states have all been refused for 5 s, and on one of which nothing has counted for
  // gate.patience_s. That time begins with the peer's first sign of life: who waits for labs to be started waits long.
  PeerWait wait_for(std::uint32_t wanted) const;

  // Free mode: the peers that say they failed or were stopped, or of which nothing has counted for 5 s while this lab
  // looked, whatever the reason, and whether
  // that ends the run; and whether robots that nobody holds back by waiting have gone on for safety.pause_after_s
  // without a new state of any peer. To be called at every step: time in which the lab itself stood still does not
  // count, for what came meanwhile is only about to be heard. Says in the log what begins and who is back, and counts
  // it as `gate.lost.<lab>` and `safety.paused`.
  PeerLook look();
  // Free mode: a state for boundary k may still come, of a peer that has not ended and that the lab does not go on
  // without.
  bool awaits(std::uint32_t k) const;

  // --- ending ---
  // A lab that failed stays for a second, so that its peers hear why. One that has finished stays to repeat its last
  // state until every peer has it for a moment, or is gone: a minute or gate.patience_s at most.
  void linger_after_failure();
  void linger_after_last_period();
  // Somebody wants the lab to go: a second more is the most.
  void hurry();
  // No peer needs this lab any more. `last`: the last period. Counts `gate.linger_gave_up`.
  bool may_leave(std::uint32_t last);
  // At the last call of may_leave() nobody lacked anything.
  bool complete() const { return complete_.has_value(); }
  // The peers are known to be complete as well, so that they need no repetition.
  void leave_complete() { linger_more_ = Now{0}; }

  const hal::Counters& counters() const { return counters_; }

 private:
  // How a peer is, by what came of it until now. It has joined when its states count.
  enum class State {
    failed,          // it said so, or that its operator stopped it
    gateway_silent,  // nobody says how its link is
    link_down,       // wait for it
    not_started,
    over,        // of the run that it told of
    not_joined,  // it runs
    dead,        // silent although its link is up
    alive,
  };

  // What came of a peer, and when.
  struct Peer {
    std::string name;
    std::optional<Now> heard, up,
        over;                          // newest sign of life; since when its link is up, and its run over, by its words
    Now met{0};                        // when the first status came after a silence
    Now counted{0};                    // when a state counted last
    Now refused_since{0}, refused{0};  // first and last message refused since one counted
    std::string said, link, refusal;   // its state and link in others' words; what was wrong with what was refused
    std::optional<std::uint32_t> applied;  // the period of its state that a boundary applied last
    bool failed = false;                   // it said so, or that its operator stopped it
    bool stopped = false;                  // the latter, or that a peer of its was
    enum class Lost { no, silent, refused } lost = Lost::no;
  };

  Peer* find(std::string_view name);  // null: no peer
  State state(const Peer& peer) const;
  // The same in words: "link down (connection refused)", "not started yet", "silent for 6 s with its link up".
  std::string words(const Peer& peer) const;
  bool gateway_silent() const { return !gateway_ || now_ - *gateway_ > gateway_limit; }
  bool lives(const Peer& peer) const { return peer.heard && now_ - *peer.heard <= status_limit; }
  Now silent_since(const Peer& peer) const { return std::max(*peer.heard, *peer.up); }
  PeerWait wait_for(const Peer& peer) const;
  void limit(PeerWait& wait, const Peer& peer, Now since, Now patience) const;
  PeerWait lose(Peer& peer);
  std::string silence();
  bool lacks_nothing(const Peer& peer, std::uint32_t last) const;

  const std::string lab_;
  const Now patience_;
  const RunConfig::OnPeerLost on_peer_lost_;
  const std::optional<Now> pause_after_;  // without news; none: never
  const PeriodGate& gate_;
  std::vector<Peer> peers_;  // ascending name
  Now now_{0}, peers_since_{0};
  std::size_t peers_bytes_ = 0;  // heard since then
  std::optional<Now> gateway_;   // when it was heard
  std::int64_t gateway_boot_id_ = 0;
  std::uint64_t unsent_ = 0;
  std::optional<Now> unsent_at_;
  std::uint32_t period_ = 0;
  Now boundary_{0}, looked_{0};  // since when the lab is at its boundary; when it looked
  std::optional<Now> news_;      // when a new state of any peer was applied; nothing before robots move
  bool silent_ = false;          // at the last look
  Now until_{0};                 // when a lab that lingers leaves at the latest
  bool left_by_failure_ = false;
  std::optional<Now> complete_;  // since when nobody lacks the last state
  Now linger_more_{500'000};     // from then on
  hal::Counters counters_;
};

}  // namespace arkmesh::lab
