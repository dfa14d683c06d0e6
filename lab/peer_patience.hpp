// For whom a lab waits, or whom it has lost, and whether that still makes sense: from what came of each peer, and when.
// The caller owns time.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "hal/counters.hpp"
#include "lab/peer_monitor.hpp"
#include "lab/period_gate.hpp"
#include "lab/run_config.hpp"

namespace arkmesh::lab {

struct PeerWait {
  std::string text;     // "waiting for roark: link down, for 590 s more"; empty when nobody is waited for
  std::string give_up;  // why nothing will come any more; empty when it still makes sense to wait
};

class PeerPatience {
 public:
  using Now = PeerMonitor::Now;

  // `gate` and `monitor` outlive it.
  PeerPatience(const RunConfig& config, const PeriodGate& gate, const PeerMonitor& monitor);

  Now most() const { return patience_; }  // gate.patience_s

  // --- what came ---
  void note_counted(std::string_view peer, Now now);  // of a peer of the gate
  void note_refused(std::string_view origin, std::string why, Now now);
  // The own state of the next boundary is published; boundary `period` is passed.
  void note_published(Now now) { boundary_ = now; }
  void note_passed(std::uint32_t period, Now now) { period_ = period, boundary_ = now; }

  // `wanted`: the period of the peers' states that the lab waits for since its last boundary. It gives up on a peer
  // that is gone, on one whose states have all been refused for 5 s, and on one of which nothing has counted for
  // gate.patience_s. That time begins with the peer's first sign of life: who waits for labs to be started waits long.
  PeerWait wait_for(std::uint32_t wanted, Now now) const;

  // Free mode: the peers of which nothing has counted for 5 s while this lab looked, whatever the reason, and whether
  // that ends the run. To be called at every step: says in the log who is lost and who is back, and counts the former
  // as `gate.lost.<lab>`.
  PeerWait lost(Now now, hal::Counters& counters);

 private:
  // What came of a peer.
  struct Contact {
    Now counted{0};                    // when a message counted last
    Now refused_since{0}, refused{0};  // first and last message refused since one counted
    std::string refusal;               // what was wrong with that
    bool lost = false, refusal_said = false;
  };
  PeerWait wait_for_one(const std::string& peer, Now now) const;
  PeerWait lose_one(const std::string& peer, Now counted, const std::string& words, Now now) const;
  void say_lost(const std::string& peer, const std::string& words) const;
  // For `patience` since then; afterwards the run ends.
  void limit(PeerWait& wait, const std::string& peer, Now since, Now patience, const std::string& words, Now now) const;

  const std::string lab_;
  const std::chrono::microseconds patience_;
  const RunConfig::OnPeerLost on_peer_lost_;
  const PeriodGate& gate_;
  const PeerMonitor& monitor_;
  std::map<std::string, Contact, std::less<>> contacts_;
  std::uint32_t period_ = 0;     // the boundary passed last
  Now boundary_{0}, looked_{0};  // since when the lab is at its boundary; when it looked for lost peers
};

}  // namespace arkmesh::lab
