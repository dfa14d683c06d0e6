#include "lab/peer_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/bus.hpp"
#include "hal/label.hpp"
#include "lab/message_check.hpp"

namespace arkmesh::lab {

namespace {

constexpr std::size_t longest_words = 200;  // of others that are quoted

// A state quoted in another's sentence: without its explanation, which may quote that other lab.
std::string without_explanation(const std::string& state) {
  return state.substr(0, state.find(": "));
}

}  // namespace

PeerMonitor::PeerMonitor(std::string lab, const std::vector<std::string>& peers) : lab_(std::move(lab)) {
  for (const std::string& peer : peers) peers_.emplace(peer, Peer{});
}

bool PeerMonitor::hear_status(std::string_view peer, std::uint64_t bound_run_id, std::span<const std::byte> bytes,
                              Now now) {
  const auto it = peers_.find(peer);
  const auto refuse = [this](std::string_view why) {
    counters_.add(fmt::format("status.refused.{}", why));
    return false;
  };
  if (it == peers_.end()) return refuse("unknown_lab");
  if (const std::string_view why = check_status(bytes); !why.empty()) return refuse(why);
  lab_status_t status;
  if (!hal::decode(bytes, status)) return refuse("undecodable");
  if (status.lab != peer) return refuse("other_name");
  if (bound_run_id != 0 && static_cast<std::uint64_t>(status.nonce) != bound_run_id) return refuse("other_run");
  if (!met(peer, now)) it->second.met = now;
  it->second.status = now;
  it->second.state = hal::printable(status.state, longest_words);
  it->second.failed = status.outcome == lab_status_t::failed || status.outcome == lab_status_t::stopped;
  if (status.outcome == lab_status_t::open)
    it->second.over.reset();
  else if (!it->second.over)
    it->second.over = now;
  return true;
}

void PeerMonitor::hear_peers(std::span<const std::byte> bytes, Now now) {
  if (const std::string_view why = check_peers(bytes); !why.empty())
    return counters_.add(fmt::format("peers.refused.{}", why));
  peers_t message;
  if (!hal::decode(bytes, message)) return counters_.add("peers.refused.undecodable");
  if (message.lab != lab_) return counters_.add("peers.refused.other_name");
  // After a silence, or from a gateway started anew, what was known of the links is void.
  if (!gateway_ || now - *gateway_ > gateway_limit || message.boot_id != gateway_boot_id_)
    for (auto& [name, peer] : peers_) peer.up.reset();
  gateway_ = now;
  gateway_boot_id_ = message.boot_id;
  for (const peer_t& said : message.peers) {
    const auto it = peers_.find(said.lab);
    if (it == peers_.end()) continue;
    it->second.why = hal::printable(said.why, longest_words);
    if (!said.up)
      it->second.up.reset();
    else if (!it->second.up)
      it->second.up = now;
  }
}

PeerMonitor::Life PeerMonitor::life(std::string_view peer, bool bound, Now now) const {
  const Peer& p = peers_.find(peer)->second;
  if (bound && p.status && p.failed) return Life::failed;
  if (!gateway_ || now - *gateway_ > gateway_limit) return Life::gateway_silent;
  if (!p.up) return Life::link_down;
  if (!bound || !p.status) return Life::unknown;
  // A status that waited in the cut link's outbox is younger than it seems, so time counts from when the link came up.
  return now - std::max(*p.status, *p.up) > status_limit ? Life::dead : Life::alive;
}

std::optional<PeerMonitor::Now> PeerMonitor::met(std::string_view peer, Now now) const {
  const Peer& p = peers_.find(peer)->second;
  return p.status && now - *p.status <= status_limit ? std::optional(p.met) : std::nullopt;
}

bool PeerMonitor::all_met(Now now) const {
  return std::ranges::all_of(peers_, [&](const auto& peer) { return met(peer.first, now) && !peer.second.over; });
}

std::string PeerMonitor::words(std::string_view peer, bool bound, Now now) const {
  const Peer& p = peers_.find(peer)->second;
  switch (life(peer, bound, now)) {
    case Life::failed:
      return p.state;
    case Life::gateway_silent:
      return fmt::format("the gateway of {} is silent; start it with: arkmesh gateway", lab_);
    case Life::link_down:
      return p.why.empty() ? "link down" : fmt::format("link down ({})", p.why);
    case Life::unknown:
      if (p.over) return fmt::format("its run is over ({})", without_explanation(p.state));
      return met(peer, now) ? fmt::format("it runs, but has not joined this run ({})", without_explanation(p.state))
                            : "not started yet";
    case Life::dead:
      return fmt::format("silent for {} s with its link up", (now - std::max(*p.status, *p.up)).count() / 1'000'000);
    case Life::alive:
      return p.state.empty() ? "running" : without_explanation(p.state);
  }
  return {};
}

}  // namespace arkmesh::lab
