// How long a lab that has finished stays to repeat its last state: until every peer has it for a moment, or is gone,
// and never longer than a minute or its patience. A lab that failed stays for a second, so that its peers hear why. The
// caller owns time.
#pragma once

#include <cstdint>
#include <optional>

#include "lab/peer_monitor.hpp"
#include "lab/period_gate.hpp"

namespace arkmesh::lab {

class Lingering {
 public:
  using Now = PeerMonitor::Now;

  void begin_after_failure(Now now);
  // `patience`: a minute is the most, but a peer whose link is cut is not waited for longer than elsewhere.
  void begin_after_last_period(Now now, Now patience);
  // Somebody wants the lab to go: a second more is the most.
  void hurry(Now now);
  // Whether the lab may go; after the last period asks what peers have. `last`: that period.
  bool over(const PeriodGate& gate, const PeerMonitor& monitor, std::uint32_t last, Now now);
  // It went although somebody may lack the last state.
  bool gave_up() const { return gave_up_; }

 private:
  Now until_{0};
  bool failed_ = false, gave_up_ = false;
  std::optional<Now> acknowledged_;  // since when nobody lacks the last state
};

}  // namespace arkmesh::lab
