#include "lab/peer_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/messages.hpp"

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr PeerExchange::Now repeat_world_after = 50ms;
constexpr PeerExchange::Now refused_limit = 5s;  // of nothing but refused states

std::string_view origin_of(std::string_view channel) {
  return channel.substr(0, channel.find('/'));
}

}  // namespace

PeerExchange::PeerExchange(const RunConfig& config, bool can_wait, std::uint64_t run_id, hal::Bus& private_bus)
    : lab_(config.lab),
      period_length_(config.period),
      patience_(config.patience),
      max_message_bytes_(config.max_message_bytes),
      bus_(private_bus),
      gate_({.lab = config.lab,
             .labs = config.labs,
             .slack = config.slack,
             .last_period = config.last_period,
             .run_id = run_id,
             .can_wait = can_wait}),
      monitor_(config.lab, gate_.peers()) {
  for (const std::string& peer : gate_.peers()) contacts_.try_emplace(peer);
  subscriptions_.push_back(bus_.subscribe(
      "[^/]+/world", [this](std::string_view channel, auto bytes) { hear_world(origin_of(channel), bytes); }));
  subscriptions_.push_back(bus_.subscribe("[^/]+/status", [this](std::string_view channel, auto bytes) {
    const std::string_view peer = origin_of(channel);
    monitor_.hear_status(peer, gate_.run_id(peer), bytes, now_);
  }));
  subscriptions_.push_back(
      bus_.subscribe(hal::channel::peers, [this](std::string_view, auto bytes) { monitor_.hear_peers(bytes, now_); }));
}

void PeerExchange::hear_world(std::string_view origin, std::span<const std::byte> bytes) {
  WorldMessage message;
  if (const std::string_view why = decode_world(bytes, message); !why.empty()) {
    note_refusal(origin, fmt::format("its message is ill-formed ({})", why));
    return counters_.add(fmt::format("world.refused.{}", why));
  }
  switch (gate_.hear(origin, message)) {
    case PeriodGate::Heard::counted:
      monitor_.hear_state(origin, now_);
      contacts_.find(origin)->second = {.counted = now_};
      if (!message.can_wait) last_state_ = now_;
      break;
    case PeriodGate::Heard::taught:
      publish_world();  // so that the peer learns our run id without waiting for a repetition
      break;
    case PeriodGate::Heard::refused:
      if (gate_.published() >= 0) note_refusal(origin, gate_.newest_refusal());
      break;
    case PeriodGate::Heard::restarted:
      if (gate_.mode() != PeriodGate::Mode::free && !complete_ && failure_.empty())
        failure_ = fmt::format("{} was restarted at period {}", origin, period_);
      break;
    case PeriodGate::Heard::different:
      if (failure_.empty()) failure_ = fmt::format("the labs' settings differ: {}", gate_.difference());
      break;
  }
}

void PeerExchange::note_refusal(std::string_view origin, std::string why) {
  const auto it = contacts_.find(origin);
  if (it == contacts_.end()) return;
  Contact& contact = it->second;
  // What an earlier run left behind comes once.
  if (contact.refusal.empty() || now_ - contact.refused > refused_limit) contact.refused_since = now_;
  contact.refused = now_;
  contact.refusal = std::move(why);
}

void PeerExchange::publish(LabState own) {
  gate_.publish(std::move(own));
  boundary_ = now_;
  publish_world();
}

std::vector<std::pair<std::string, const LabState*>> PeerExchange::merge(std::uint32_t k) {
  period_ = k;
  boundary_ = merged_ = now_;
  return gate_.merge(k);
}

bool PeerExchange::may_begin_next_period() const {
  if (period_ == 0 || gate_.may_begin(period_ + 1)) return true;
  return now_ - last_state_ > 2 * period_length_ && now_ - merged_ >= period_length_;
}

void PeerExchange::publish_world() {
  const world_t message = to_message(gate_.message());
  if (const auto bytes = static_cast<std::size_t>(message.getEncodedSize());
      bytes > max_message_bytes_ && !gate_.peers().empty() && failure_.empty())
    failure_ = fmt::format(
        "the message of {} to its peers has {} bytes at period {}, and gateway.max_message_bytes = {}: raise that in "
        "all labs, or take fewer robots",
        lab_, bytes, gate_.published(), max_message_bytes_);
  bus_.publish(hal::channel::world, message);
  world_due_ = now_ + repeat_world_after;
}

bool PeerExchange::repeat_world() {
  if (now_ < world_due_) return false;
  publish_world();
  return true;
}

PeerWait PeerExchange::wait_for(std::uint32_t wanted) const {
  PeerWait all;
  for (const std::string& peer : gate_.peers()) {
    if (gate_.received(peer) >= static_cast<std::int64_t>(wanted)) continue;
    PeerWait one = wait_for_one(peer);
    all.text += (all.text.empty() ? "waiting for " : "; ") + one.text;
    if (all.give_up.empty()) all.give_up = std::move(one.give_up);
  }
  return all;
}

PeerWait PeerExchange::wait_for_one(const std::string& peer) const {
  const bool bound = gate_.bound(peer);
  const Contact& contact = contacts_.find(peer)->second;
  const PeerMonitor::Life life = monitor_.life(peer, bound, now_);
  const std::string words = monitor_.words(peer, bound, now_);
  PeerWait wait{.text = fmt::format("{}: {}", peer, words), .give_up = {}};
  if (life == PeerMonitor::Life::failed || life == PeerMonitor::Life::dead) {
    wait.give_up = fmt::format("{} is gone at period {}: {}", peer, period_, words);
  } else if (!contact.refusal.empty() &&
             contact.refused - std::max(contact.refused_since, boundary_) >= refused_limit) {
    wait.give_up = fmt::format(
        "{} refuses every state of {} at period {}: {}; do both run the same program with the same settings?", lab_,
        peer, period_, contact.refusal);
  } else if (const auto since = bound ? std::optional(contact.counted) : monitor_.met(peer, now_)) {
    // A cut link may be waited for not at all; what lives has a moment to speak.
    const bool cut = life == PeerMonitor::Life::link_down || life == PeerMonitor::Life::gateway_silent;
    const Now patience = cut ? patience_ : std::max<Now>(patience_, PeerMonitor::status_limit);
    const Now left = std::max(*since, boundary_) + patience - now_;
    wait.text += fmt::format(", for {} s more", std::chrono::ceil<std::chrono::seconds>(left).count());
    if (left < Now{0})
      wait.give_up = fmt::format("gave up waiting for {} after {} s at period {} of {} (gate.patience_s): {}", peer,
                                 patience.count() / 1'000'000, period_, lab_, words);
  } else {
    wait.text += ", until it comes or the lab is stopped";
  }
  return wait;
}

void PeerExchange::linger_after_last_period() {
  complete_ = true;
  lingering_.begin_after_last_period(now_, patience_);
  publish_world();
}

bool PeerExchange::may_leave(std::uint32_t last) {
  if (!lingering_.over(gate_, monitor_, last, now_)) return false;
  if (lingering_.gave_up()) counters_.add("gate.linger_gave_up");
  return true;
}

std::map<std::string, std::uint64_t> PeerExchange::hash_by_lab(std::uint64_t own) const {
  std::map<std::string, std::uint64_t> hashes{{lab_, own}};
  for (const std::string& peer : gate_.peers()) {
    const LabState* newest = gate_.newest(peer);
    hashes[peer] = newest ? newest->hash : 0;
  }
  return hashes;
}

hal::Counters PeerExchange::counters() const {
  hal::Counters all = counters_;
  all.merge(gate_.counters());
  all.merge(monitor_.counters());
  return all;
}

}  // namespace arkmesh::lab
