#include "lab/peer_patience.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr PeerPatience::Now lost_after = 5s;     // without anything that counts
constexpr PeerPatience::Now refused_limit = 5s;  // of nothing but refused states
constexpr PeerPatience::Now away_after = 3s;     // without a look: the lab itself stood still

}  // namespace

PeerPatience::PeerPatience(const RunConfig& config, const PeriodGate& gate, const PeerMonitor& monitor)
    : lab_(config.lab), patience_(config.patience), on_peer_lost_(config.on_peer_lost), gate_(gate), monitor_(monitor) {
  for (const std::string& peer : gate_.peers()) contacts_.try_emplace(peer);
}

void PeerPatience::note_counted(std::string_view peer, Now now) {
  Contact& contact = contacts_.find(peer)->second;
  contact = {.counted = now, .lost = contact.lost};
}

void PeerPatience::note_refused(std::string_view origin, std::string why, Now now) {
  const auto it = contacts_.find(origin);
  if (it == contacts_.end()) return;
  Contact& contact = it->second;
  // What an earlier run left behind comes once.
  if (contact.refusal.empty() || now - contact.refused > refused_limit) contact.refused_since = now;
  contact.refused = now;
  contact.refusal = std::move(why);
}

// ---------------------------------------------------------------- waiting

PeerWait PeerPatience::wait_for(std::uint32_t wanted, Now now) const {
  PeerWait all;
  for (const std::string& peer : gate_.peers()) {
    if (gate_.has(peer, wanted)) continue;
    PeerWait one = wait_for_one(peer, now);
    all.text += (all.text.empty() ? "waiting for " : "; ") + one.text;
    // In free mode lost() decides.
    if (all.give_up.empty() && gate_.mode() != PeriodGate::Mode::free) all.give_up = std::move(one.give_up);
  }
  return all;
}

PeerWait PeerPatience::wait_for_one(const std::string& peer, Now now) const {
  const bool bound = gate_.bound(peer);
  const Contact& contact = contacts_.find(peer)->second;
  const PeerMonitor::Life life = monitor_.life(peer, bound, now);
  const std::string words = monitor_.words(peer, bound, now);
  PeerWait wait{.text = fmt::format("{}: {}", peer, words), .give_up = {}};
  if (life == PeerMonitor::Life::failed || life == PeerMonitor::Life::dead) {
    wait.give_up = fmt::format("{} is gone at period {}: {}", peer, period_, words);
  } else if (!contact.refusal.empty() &&
             contact.refused - std::max(contact.refused_since, boundary_) >= refused_limit) {
    wait.give_up = fmt::format(
        "{} refuses every state of {} at period {}: {}; do both run the same program with the same settings?", lab_,
        peer, period_, contact.refusal);
  } else if (const auto since = bound                 ? std::optional(contact.counted)
                                : monitor_.over(peer) ? monitor_.over(peer)
                                                      : monitor_.met(peer, now)) {
    // A cut link may be waited for not at all; what lives has a moment to speak.
    const bool cut = life == PeerMonitor::Life::link_down || life == PeerMonitor::Life::gateway_silent;
    limit(wait, peer, std::max(*since, boundary_), cut ? patience_ : std::max<Now>(patience_, lost_after), words, now);
  } else {
    wait.text += ", until it comes or the lab is stopped";
  }
  return wait;
}

void PeerPatience::limit(PeerWait& wait, const std::string& peer, Now since, Now patience, const std::string& words,
                         Now now) const {
  const Now left = since + patience - now;
  wait.text += fmt::format(", for {} s more", std::chrono::ceil<std::chrono::seconds>(left).count());
  if (left < Now{0})
    wait.give_up = fmt::format("gave up waiting for {} after {} s at period {} of {} (gate.patience_s): {}", peer,
                               patience.count() / 1'000'000, period_, lab_, words);
}

// ---------------------------------------------------------------- lost peers

PeerWait PeerPatience::lost(Now now, hal::Counters& counters) {
  PeerWait all;
  // What came while the lab itself stood still is only about to be heard.
  const Now away = now - std::exchange(looked_, now);
  if (gate_.mode() != PeriodGate::Mode::free) return all;
  for (auto& [peer, contact] : contacts_) {
    if (away > away_after) contact.counted = std::min(contact.counted + away, now);
    const bool lost = now - contact.counted > lost_after && !gate_.done(peer), was = std::exchange(contact.lost, lost);
    if (was && !lost) spdlog::warn("{} is back at period {} of {}", peer, period_, lab_);
    if (!lost) continue;
    const std::string words = contact.refusal.empty() ? monitor_.words(peer, true, now) : contact.refusal;
    PeerWait one = lose_one(peer, contact.counted, words, now);
    if (!was) {
      counters.add("gate.lost." + peer);
      if (one.give_up.empty()) say_lost(peer, words);
    } else if (!contact.refusal.empty() && !contact.refusal_said) {
      spdlog::warn("{} refuses what comes from {} at period {}: {}", lab_, peer, period_, contact.refusal);
    }
    contact.refusal_said = !contact.refusal.empty();
    all.text += (all.text.empty() ? "" : "; ") + one.text;
    if (all.give_up.empty()) all.give_up = std::move(one.give_up);
  }
  return all;
}

PeerWait PeerPatience::lose_one(const std::string& peer, Now counted, const std::string& words, Now now) const {
  PeerWait one{.text = fmt::format("{}: {}", peer, words), .give_up = {}};
  if (on_peer_lost_ == RunConfig::OnPeerLost::end)
    one.give_up = fmt::format("{} has lost {} at period {}: {}; start all labs again (gate.on_peer_lost = \"end\")",
                              lab_, peer, period_, words);
  else if (on_peer_lost_ == RunConfig::OnPeerLost::pause)
    limit(one, peer, counted, std::max<Now>(patience_, lost_after), words, now);
  return one;
}

void PeerPatience::say_lost(const std::string& peer, const std::string& words) const {
  const bool pause = on_peer_lost_ == RunConfig::OnPeerLost::pause;
  spdlog::warn("{} has lost {} at period {}: {}; {}; start {} again or mend the link (gate.on_peer_lost = \"{}\")",
               lab_, peer, period_, words,
               pause ? fmt::format("robots pause until it is back, for {} s at most", patience_.count() / 1'000'000)
                     : "robots go on beside its last state",
               peer, pause ? "pause" : "go_on");
}

}  // namespace arkmesh::lab
