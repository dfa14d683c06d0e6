#include "lab/lingering.hpp"

#include <algorithm>

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr Lingering::Now linger_more = 500ms, linger_most = 60s, fail_linger = 1s;

bool lacks_nothing(const PeriodGate& gate, const PeerMonitor& monitor, const std::string& peer, std::uint32_t last,
                   Lingering::Now now) {
  const auto life = monitor.life(peer, gate.bound(peer), now);
  if (life == PeerMonitor::Life::dead || life == PeerMonitor::Life::failed) return true;
  // A free peer may be behind, and the final hash is made of its last state.
  return gate.mode() == PeriodGate::Mode::strict ? gate.acknowledged(peer, last) : gate.done(peer);
}

}  // namespace

void Lingering::begin_after_failure(Now now) {
  failed_ = true;
  until_ = now + fail_linger;
}

void Lingering::begin_after_last_period(Now now, Now patience) {
  until_ = now + std::clamp<Now>(patience, PeerMonitor::status_limit, linger_most);
}

void Lingering::hurry(Now now) {
  until_ = std::min<Now>(until_, now + fail_linger);
}

bool Lingering::over(const PeriodGate& gate, const PeerMonitor& monitor, std::uint32_t last, Now now) {
  const bool too_long = now >= until_;
  if (failed_) return too_long;
  gave_up_ = too_long;
  const bool all = std::all_of(gate.peers().begin(), gate.peers().end(),
                               [&](const std::string& peer) { return lacks_nothing(gate, monitor, peer, last, now); });
  if (!all)
    acknowledged_.reset();
  else if (!acknowledged_)
    acknowledged_ = now;
  return too_long || (all && (gate.peers().empty() || now - *acknowledged_ >= linger_more));
}

}  // namespace arkmesh::lab
