// Tells a dead peer from a cut link: link up and the peer's status old means dead; link down means wait. Pure; the
// caller owns time.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::lab {

class PeerMonitor {
 public:
  using Now = std::chrono::microseconds;
  static constexpr Now status_limit{5'000'000};   // link up and no status for so long: dead
  static constexpr Now gateway_limit{3'000'000};  // no `peers` for so long: our own gateway is silent

  PeerMonitor(std::string lab, const std::vector<std::string>& peers);

  // `<peer>/status` and our gateway's `peers`, as they came; what is ill-formed or about others is refused and counted.
  // `bound_run_id`: the run id of the run that counts, 0 before it is known. A status of another run is ignored and
  // counted. False: it was refused.
  bool hear_status(std::string_view peer, std::uint64_t bound_run_id, std::span<const std::byte> bytes, Now now);
  void hear_peers(std::span<const std::byte> bytes, Now now);
  // A state of the peer counted: as much a sign of life as a status, which a fast run may not have come to yet.
  void hear_state(std::string_view peer, Now now) { peers_.find(peer)->second.status = now; }

  enum class Life { unknown, link_down, gateway_silent, alive, dead, failed };
  // `bound`: its states count, so that it has been alive in this run.
  Life life(std::string_view peer, bool bound, Now now) const;
  // Since when a peer whose states do not count has given signs of life without a break; none when it gives none.
  std::optional<Now> met(std::string_view peer, Now now) const;
  // Each peer gives signs of life, and of a run that is not over.
  bool all_met(Now now) const;
  // Since when a peer's newest status says that its run is over, whether or not it has said anything since.
  std::optional<Now> over(std::string_view peer) const { return peers_.find(peer)->second.over; }
  // Its life in words: "link down (connection refused)", "not started yet", "silent for 6 s".
  std::string words(std::string_view peer, bool bound, Now now) const;
  const hal::Counters& counters() const { return counters_; }

 private:
  struct Peer {
    std::optional<Now> status, up;  // when last heard; since when the link is up
    Now met{0};                     // when the first status came after a silence
    std::string state, why;
    bool failed = false;      // it said so, or that its operator stopped it
    std::optional<Now> over;  // since when it has said that its run is over
  };
  std::string lab_;
  std::map<std::string, Peer, std::less<>> peers_;
  std::optional<Now> gateway_;
  std::int64_t gateway_boot_id_ = 0;
  hal::Counters counters_;
};

}  // namespace arkmesh::lab
