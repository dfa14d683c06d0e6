#include "lab/exchange/peers.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/bus/bus.hpp"
#include "hal/label.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t longest_words = 200;          // of others that are quoted
constexpr Peers::Now lost_after = 5s;               // without anything that counts
constexpr Peers::Now refused_limit = 5s;            // of nothing but refused states
constexpr Peers::Now away_after = 3s;               // without a look: the lab itself stood still
constexpr std::size_t max_peers_bytes = 256 << 10;  // a second; a gateway says a few kB
constexpr Peers::Now linger_most = 60s, linger_little = 1s;

// A state quoted in another's sentence: without its explanation, which may quote that other lab.
std::string without_explanation(const std::string& state) {
  return state.substr(0, state.find(": "));
}

void append(PeerWait& all, std::string_view before_first, PeerWait one) {
  all.text.append(all.text.empty() ? before_first : "; ").append(one.text);
  if (!all.give_up.empty() || one.give_up.empty()) return;
  all.give_up = std::move(one.give_up);
  all.stopped = one.stopped;
}

// How long robots go on without news; none: for ever, as where simulated ones wait, or there is nobody to hear of.
std::optional<Peers::Now> pause_after(const RunConfig& config, bool can_wait) {
  if (can_wait || config.labs.size() < 2 || config.safety.pause_after == Peers::Now{0}) return {};
  return std::max<Peers::Now>(config.safety.pause_after, 2 * config.period);
}

}  // namespace

Peers::Peers(const RunConfig& config, bool can_wait, const PeriodGate& gate)
    : lab_(config.lab),
      patience_(config.patience),
      on_peer_lost_(config.on_peer_lost),
      pause_after_(lab::pause_after(config, can_wait)),
      gate_(gate) {
  for (const std::string& peer : gate_.peers()) peers_.push_back({.name = peer});
}

Peers::Peer* Peers::find(std::string_view name) {
  const auto it = std::ranges::lower_bound(peers_, name, {}, &Peer::name);
  return it == peers_.end() || it->name != name ? nullptr : &*it;
}

// ---------------------------------------------------------------- what came

bool Peers::hear_status(std::string_view name, std::span<const std::byte> bytes) {
  const auto refuse = [this](std::string_view why) {
    counters_.add(fmt::format("status.refused.{}", why));
    return false;
  };
  Peer* peer = find(name);
  if (!peer) return refuse("unknown_lab");
  lab_status_t status;
  if (const std::string_view why = hal::read_message(bytes, status); !why.empty()) return refuse(why);
  if (status.lab != name) return refuse("other_name");
  const std::uint64_t run_id = gate_.run_id(name);
  if (run_id != 0 && static_cast<std::uint64_t>(status.nonce) != run_id) return refuse("other_run");
  if (!lives(*peer)) peer->met = now_;
  peer->heard = now_;
  peer->said = hal::printable(status.state, longest_words);
  peer->stopped = status.outcome == lab_status_t::stopped;
  peer->failed = status.outcome == lab_status_t::failed || peer->stopped;
  if (status.outcome == lab_status_t::open)
    peer->over.reset();
  else if (!peer->over)
    peer->over = now_;
  return true;
}

bool Peers::hear_peers(std::span<const std::byte> bytes) {
  const auto refuse = [this](std::string_view why) {
    counters_.add(fmt::format("peers.refused.{}", why));
    return false;
  };
  if (now_ - peers_since_ >= 1s) peers_since_ = now_, peers_bytes_ = 0;
  const bool is_recorded = (peers_bytes_ += bytes.size()) <= max_peers_bytes;
  peers_t message;
  if (const std::string_view why = hal::read_message(bytes, message); !why.empty()) return refuse(why);
  if (message.lab != lab_) return refuse("other_name");
  // After a silence, or from a gateway started anew, what was known of the links is void.
  if (gateway_silent() || message.boot_id != gateway_boot_id_)
    for (Peer& peer : peers_) peer.up.reset();
  gateway_ = now_;
  gateway_boot_id_ = message.boot_id;
  for (const peer_t& said : message.peers) {
    Peer* peer = find(said.lab);
    if (!peer) continue;
    peer->link = hal::printable(said.why, longest_words);
    if (!said.up)
      peer->up.reset();
    else if (!peer->up)
      peer->up = now_;
  }
  return is_recorded;
}

void Peers::note_counted(std::string_view name) {
  Peer& peer = *find(name);
  peer.heard = peer.counted = now_;
  peer.refusal.clear();
}

void Peers::note_refused(std::string_view origin, std::string why) {
  Peer* peer = find(origin);
  if (!peer) return;
  // What an earlier run left behind comes once.
  if (peer->refusal.empty() || now_ - peer->refused > refused_limit) peer->refused_since = now_;
  peer->refused = now_;
  peer->refusal = std::move(why);
}

void Peers::note_merged(std::uint32_t period, const std::vector<MergedState>& merged) {
  period_ = period;
  boundary_ = now_;
  if (!pause_after_) return;
  bool news = !news_;
  for (const MergedState& one : merged) {
    Peer* peer = find(one.lab);
    if (!peer) continue;
    news = news || !peer->applied || one.initial || one.state->period > *peer->applied;
    peer->applied = one.state->period;
  }
  if (news) news_ = now_;
}

// ---------------------------------------------------------------- how peers are

Peers::State Peers::state(const Peer& peer) const {
  const bool joined = gate_.bound(peer.name) && peer.heard;
  if (joined && peer.failed) return State::failed;
  if (gateway_silent()) return State::gateway_silent;
  if (!peer.up) return State::link_down;
  if (!joined) return peer.over ? State::over : lives(peer) ? State::not_joined : State::not_started;
  // A status that waited in the cut link's outbox is younger than it seems, so time counts from when the link came up.
  return now_ - silent_since(peer) > status_limit ? State::dead : State::alive;
}

std::string Peers::words(const Peer& peer) const {
  switch (state(peer)) {
    case State::failed:
      return peer.said;
    case State::gateway_silent:
      if (unsent_at_ && now_ - *unsent_at_ <= gateway_limit)
        return fmt::format("the network of {} is gone: its bus could not send {} messages", lab_, unsent_);
      return fmt::format("the gateway of {} is silent; start it with: arkmesh gateway", lab_);
    case State::link_down:
      return peer.link.empty() ? "link down" : fmt::format("link down ({})", peer.link);
    case State::not_started:
      return "not started yet";
    case State::over:
      return fmt::format("its run is over ({})", without_explanation(peer.said));
    case State::not_joined:
      return fmt::format("it is running, but has not joined this run ({})", without_explanation(peer.said));
    case State::dead:
      return fmt::format("silent for {} s with its link up", (now_ - silent_since(peer)).count() / 1'000'000);
    case State::alive:
      break;
  }
  return peer.said.empty() ? "running" : without_explanation(peer.said);
}

bool Peers::all_met() const {
  return std::ranges::all_of(peers_, [this](const Peer& peer) { return lives(peer) && !peer.over; });
}

// ---------------------------------------------------------------- waiting

PeerWait Peers::wait_for(std::uint32_t wanted) const {
  PeerWait all;
  for (const Peer& peer : peers_)
    if (!gate_.has(peer.name, wanted)) append(all, "waiting for ", wait_for(peer));
  if (gate_.mode() == PeriodGate::Mode::free) all.give_up.clear();  // look() decides
  return all;
}

PeerWait Peers::wait_for(const Peer& peer) const {
  const State is = state(peer);
  PeerWait wait{.text = fmt::format("{}: {}", peer.name, words(peer)), .give_up = {}, .stopped = peer.stopped};
  std::optional<Now> since = peer.over;
  if (gate_.bound(peer.name))
    since = peer.counted;
  else if (!since && lives(peer))
    since = peer.met;
  if (is == State::failed || is == State::dead) {
    wait.give_up = fmt::format("{} is gone at period {}: {}", peer.name, period_, words(peer));
  } else if (!peer.refusal.empty() && peer.refused - std::max(peer.refused_since, boundary_) >= refused_limit) {
    wait.give_up = fmt::format(
        "{} refuses every state of {} at period {}: {}; do both run the same version with the same settings?", lab_,
        peer.name, period_, peer.refusal);
  } else if (since) {
    // A cut link may be waited for not at all; what lives has a moment to speak.
    const bool cut = is == State::link_down || is == State::gateway_silent;
    limit(wait, peer, std::max(*since, boundary_), cut ? patience_ : std::max(patience_, lost_after));
  } else {
    wait.text += ", until it connects or the lab is stopped";
  }
  return wait;
}

// For `patience` since then; afterwards the run ends.
void Peers::limit(PeerWait& wait, const Peer& peer, Now since, Now patience) const {
  const Now left = since + patience - now_;
  if (left < Now{0})
    wait.give_up = fmt::format("gave up waiting for {} after {} s at period {} of {} (gate.patience_s): {}", peer.name,
                               patience.count() / 1'000'000, period_, lab_, wait.text.substr(peer.name.size() + 2));
  wait.text += fmt::format(", for {} s more", std::chrono::ceil<std::chrono::seconds>(left).count());
}

// ---------------------------------------------------------------- free mode

PeerLook Peers::look() {
  const Now away = now_ - std::exchange(looked_, now_);
  const auto leave_out = [&](Now& then) {
    if (away > away_after) then = std::min(then + away, now_);
  };
  PeerLook seen;
  for (Peer& peer : peers_) {
    leave_out(peer.counted);
    if (PeerWait one = lose(peer); !one.text.empty()) append(seen.lost, "", std::move(one));
  }
  if (news_) leave_out(*news_);
  if (seen.lost.give_up.empty()) seen.silence = silence();
  return seen;
}

// Empty when it is not lost.
PeerWait Peers::lose(Peer& peer) {
  using Lost = Peer::Lost;
  using OnPeerLost = RunConfig::OnPeerLost;
  if (state(peer) == State::failed && peer.said.find(all_again) != std::string::npos) {
    const std::string why = fmt::format("{} is gone at period {}: {}", peer.name, period_, peer.said);
    return {.text = why, .give_up = why, .stopped = false};
  }
  Lost is = Lost::no;
  // Who says that it failed, or that its operator stopped it, is not heard of any more.
  if ((now_ - peer.counted > lost_after || state(peer) == State::failed) && !gate_.done(peer.name))
    is = peer.refusal.empty() ? Lost::silent : Lost::refused;
  const Lost was = std::exchange(peer.lost, is);
  if (is == Lost::no) {
    if (was != Lost::no) spdlog::warn("{} is back at period {} of {}", peer.name, period_, lab_);
    return {};
  }
  const std::string why = is == Lost::refused ? peer.refusal : words(peer);
  const bool pause = on_peer_lost_ == OnPeerLost::pause;
  PeerWait wait{.text = fmt::format("{}: {}", peer.name, why), .give_up = {}, .stopped = peer.stopped};
  if (on_peer_lost_ == OnPeerLost::end)
    wait.give_up = fmt::format("{} has lost {} at period {}: {}; start all labs again (gate.on_peer_lost = \"end\")",
                               lab_, peer.name, period_, why);
  else if (pause)
    limit(wait, peer, peer.counted, std::max(patience_, lost_after));
  if (was == Lost::no) counters_.add("gate.lost." + peer.name);
  if (was == Lost::no && wait.give_up.empty())
    spdlog::warn("{} has lost {} at period {}: {}; {}; restart {} or repair the link (gate.on_peer_lost = \"{}\")",
                 lab_, peer.name, period_, why,
                 pause ? fmt::format("robots pause until it is back, for {} s at most", patience_.count() / 1'000'000)
                       : "robots continue with its last state",
                 peer.name, pause ? "pause" : "go_on");
  else if (was == Lost::silent && is == Lost::refused)
    spdlog::warn("{} refuses the states of {} at period {}: {}", lab_, peer.name, period_, why);
  return wait;
}

bool Peers::awaits(std::uint32_t k) const {
  return std::ranges::any_of(peers_, [&](const Peer& peer) {
    const bool gone_on = peer.lost != Peer::Lost::no && on_peer_lost_ == RunConfig::OnPeerLost::go_on;
    return !gate_.has(peer.name, gate_.wanted(k)) && !gate_.done(peer.name) && !gone_on;
  });
}

// Peers that have reached their last period have nothing new to tell.
std::string Peers::silence() {
  const bool silent = pause_after_ && news_ && now_ - *news_ > *pause_after_ &&
                      !std::ranges::all_of(peers_, [this](const Peer& peer) { return gate_.done(peer.name); });
  const bool was = std::exchange(silent_, silent);
  if (!silent) return {};
  std::string words =
      fmt::format("no new state of any peer for {} s", std::chrono::floor<std::chrono::seconds>(now_ - *news_).count());
  if (!was) {
    counters_.add("safety.paused");
    spdlog::warn("{} pauses its robots at period {}: {} (safety.pause_after_s); they resume with the next one", lab_,
                 period_, words);
  }
  return words;
}

// ---------------------------------------------------------------- ending

void Peers::linger_after_failure() {
  left_by_failure_ = true;
  until_ = now_ + linger_little;
}

void Peers::linger_after_last_period() {
  // A peer whose link is cut is not waited for longer than elsewhere.
  until_ = now_ + std::clamp(patience_, status_limit, linger_most);
}

void Peers::hurry() {
  until_ = std::min(until_, now_ + linger_little);
}

bool Peers::lacks_nothing(const Peer& peer, std::uint32_t last) const {
  const State is = state(peer);
  if (is == State::dead || is == State::failed) return true;
  // A free peer may be behind, and the final hash is made of its last state.
  return gate_.mode() == PeriodGate::Mode::strict ? gate_.acknowledged(peer.name, last) : gate_.done(peer.name);
}

bool Peers::may_leave(std::uint32_t last) {
  const bool too_long = now_ >= until_;
  if (left_by_failure_) return too_long;
  if (too_long) counters_.add("gate.linger_gave_up");
  if (!std::ranges::all_of(peers_, [&](const Peer& peer) { return lacks_nothing(peer, last); }))
    complete_.reset();
  else if (!complete_)
    complete_ = now_;
  return too_long || (complete_ && (peers_.empty() || now_ - *complete_ >= linger_more_));
}

}  // namespace arkmesh::lab
