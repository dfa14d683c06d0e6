#include "lab/exchange/period_gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "hal/counted.hpp"
#include "lab/exchange/payload.hpp"

namespace arkmesh::lab {

// Of one peer in one run of this lab. Each is remembered.
constexpr std::size_t max_former_runs = 100;

PeriodGate::PeriodGate(Options options) : options_(std::move(options)), last_period_(options_.last_period) {
  if (options_.window == 0) options_.window = window_of(options_.slack);
  std::sort(options_.labs.begin(), options_.labs.end());
  for (const std::string& lab : options_.labs)
    if (lab != options_.lab) {
      peer_names_.push_back(lab);
      peers_.emplace(lab, Peer{});
    }
}

// Strict labs are at most slack + 1 periods apart, so the window is all that a peer can need. A real-time arena runs
// ahead by as much as its clock began earlier; 256 periods of it are kept.
std::size_t PeriodGate::kept() const {
  return mode_ == Mode::free ? 256 : window_of(options_.slack);
}

void PeriodGate::publish(LabState own) {
  assert(static_cast<std::int64_t>(own.period) == published_ + 1);
  published_ = own.period;
  const auto kept = std::make_shared<const LabState>(std::move(own));
  if (published_ == 0) initial_ = kept;
  own_.emplace(kept->period, kept);
  event_.reset();
  if (own_.size() > std::max<std::size_t>(options_.window, options_.slack + 1)) own_.erase(own_.begin());
  decide_mode();
}

WorldMessage PeriodGate::message() const {
  WorldMessage m;
  m.lab = options_.lab;
  m.run_id = options_.run_id;
  m.can_wait = options_.can_wait;
  m.done = published_ == static_cast<std::int64_t>(last_period_);
  bool initial_known = true;
  m.acks.reserve(peers_.size());
  for (const auto& [name, peer] : peers_) {
    m.acks.emplace_hint(m.acks.end(), name, Ack{peer.run_id, peer.received});
    initial_known = initial_known && peer.acknowledged >= 0;
  }
  const std::size_t skip = own_.size() > options_.window ? own_.size() - options_.window : 0;
  auto first = std::next(own_.begin(), static_cast<std::ptrdiff_t>(skip));
  // In free mode nobody waits for a peer that has missed state 0 until now.
  if (published_ >= 0 && !initial_known && first->first != 0 && options_.window > 1 && mode_ == Mode::free)
    m.window.push_back(*initial_);
  for (; first != own_.end(); ++first) m.window.push_back(*first->second);
  leave_out_known(m.window);
  m.event = event_;
  return m;
}

PeriodGate::Heard PeriodGate::refuse(const Refusal& refusal) {
  counters_.add(fmt::format("world.refused.{}", refusal.why));
  newest_refusal_ = refusal.sentence;
  return Heard::refused;
}

std::optional<Refusal> PeriodGate::own_refusal(const LabState& own) const {
  return rules_ ? rules_->refusal(options_.lab, own, own.period == 0 ? own : *initial_) : std::nullopt;
}

std::optional<Refusal> PeriodGate::refusal(const Peer& peer, const WorldMessage& message) const {
  const auto because = [](std::string_view why, std::string sentence) { return Refusal{why, std::move(sentence)}; };
  const Ack& ack = message.acks.find(options_.lab)->second;
  if (ack.received > published_)
    return because("acknowledges_the_future",
                   fmt::format("it acknowledges our state {}, but the newest is {}", ack.received, published_));
  if (peer.bound && peer.can_wait != message.can_wait)
    return because("can_wait_changed", "its arena's can_wait changed");
  // The first message that arrives may hold state 0 and later ones at once.
  const LabState* initial = peer.received >= 0 ? peer.initial.get() : nullptr;
  if (!initial && !message.window.empty() && message.window.front().period == 0) initial = &message.window.front();
  std::int64_t last = -1, payload = -1;
  if (!peer.states.empty()) payload = payload_period(*peer.states.rbegin()->second);
  for (const LabState& state : message.window) {
    const std::int64_t period = state.period;
    if (period <= last) return because("order", fmt::format("its state {} follows state {}", period, last));
    if (period > last + 1 && last > 0)
      return because("gap", fmt::format("its state {} follows state {}", period, last));
    last = period;
    if (period > newest_of_peers() || (mode_ == Mode::strict && period > published_ + options_.slack + 1))
      return because("period", fmt::format("its state {} is from the future", period));
    if ((period == 0) == state.settings.empty())
      return because("settings",
                     fmt::format("its state {} has {}", period, hal::counted(state.settings.size(), "setting")));
    if (const auto known = peer.states.find(state.period); known != peer.states.end()) {
      if (known->second->hash != state.hash || (state.carried && known->second->robots.size() != state.robots.size()))
        return because("changed", fmt::format("its state {} has changed since it was first sent", period));
    } else if (period > peer.received) {
      if (auto refused = payload_refusal(state, payload)) return refused;
      if (!rules_ || !state.carried) continue;
      if (!initial) return because("before_initial", fmt::format("its state {} came before its state 0", period));
      if (auto refused = rules_->refusal(message.lab, state, *initial)) {
        refused->sentence.insert(0, fmt::format("state {}: ", period));
        return refused;
      }
    }
  }
  return event_refusal(peer, message);
}

bool PeriodGate::find_difference(std::string_view peer, const LabState& initial) {
  const auto& ours = initial_->settings;
  const auto& theirs = initial.settings;
  const auto differ = [&](const std::string& key, std::string_view here, std::string_view there) {
    difference_ = fmt::format("{} is {} in {} and {} in {}", key, here, options_.lab, there, peer);
    return true;
  };
  const auto tells = [](const auto& settings, const std::string& key) {  // an earlier arkmesh tells nothing of fields
    return !key.starts_with("field.") || settings.contains("field.");
  };
  for (const auto& [key, value] : ours) {
    const auto other = theirs.find(key);
    if (!tells(theirs, key)) continue;
    if (other == theirs.end()) return differ(key, value, "not set");
    if (other->second != value) return differ(key, value, other->second);
  }
  for (const auto& [key, value] : theirs)
    if (!ours.contains(key) && tells(ours, key)) return differ(key, "not set", value);
  return false;
}

PeriodGate::Heard PeriodGate::hear(std::string_view origin, const std::shared_ptr<const WorldMessage>& shared) {
  const WorldMessage& message = *shared;
  if (message.lab != origin) return refuse({"other_name", fmt::format("it calls itself {}", message.lab)});
  const auto it = peers_.find(origin);
  if (it == peers_.end()) return refuse("unknown_lab");
  Peer& peer = it->second;
  if (message.run_id == 0) return refuse("run_id");
  const auto ack = message.acks.find(options_.lab);
  if (ack == message.acks.end())
    return refuse({"not_for_us", fmt::format("it does not know {}; is shared.labs the same in both?", options_.lab)});
  if (ack->second.run_id != options_.run_id) {
    // From before it knew us, or from an earlier run: teaches its run id unless we hold on to one that counts.
    if (!peer.bound) peer.run_id = message.run_id;
    counters_.add("world.taught");
    return Heard::taught;
  }
  if (published_ < 0) return refuse("early");
  if (peer.bound && peer.run_id != message.run_id) {
    if (std::ranges::count(peer.former_runs, message.run_id) > 0)
      return refuse(Refusal{"former_run", "it is from an earlier run"});
    if (mode_ != Mode::free) return counters_.add("world.restarted"), Heard::restarted;
    if (const auto refused = begin_anew(peer, message)) return refuse(*refused);
  }
  if (peer.received < 0 && !message.window.empty() && message.window.front().period == 0 &&
      find_difference(origin, message.window.front()))
    return Heard::different;
  if (const auto refused = refusal(peer, message)) return refuse(*refused);

  // An arena that keeps real time and begins while this peer is in mid-run keeps that distance.
  const std::int64_t newest = message.window.empty() ? 0 : message.window.back().period;
  if (!peer.bound && !options_.can_wait && newest > published_ + window_of(options_.slack))
    peer.ahead = newest - published_;
  peer.bound = true;
  peer.run_id = message.run_id;
  peer.can_wait = message.can_wait;
  peer.acknowledged = std::max(peer.acknowledged, ack->second.received);
  for (const LabState& state : message.window) accept(peer, KeptState(shared, &state));
  if (message.event) accept_event(peer, *message.event);
  if (message.done && !message.window.empty() &&
      peer.received >= static_cast<std::int64_t>(message.window.back().period))
    peer.done = true;
  counters_.add("world.counted");
  decide_mode();
  return Heard::counted;
}

// Free: nobody waits for what a peer has forgotten, so its new run takes the place of the former one. An arena that
// keeps real time begins where the others are, and keeps that distance; one that can wait catches up.
std::optional<Refusal> PeriodGate::begin_anew(Peer& peer, const WorldMessage& message) {
  if (peer.former_runs.size() >= max_former_runs)
    return Refusal{"restarted", fmt::format("it was restarted {} times; start all labs again", max_former_runs)};
  if (published_ >= static_cast<std::int64_t>(last_period_))
    return Refusal{"restarted", "it was restarted after the last period"};
  if (message.window.empty() || message.window.front().period != 0)
    return Refusal{"before_initial", "it was restarted and has no state 0"};
  if (find_difference(message.lab, message.window.front()))
    return Refusal{"settings", fmt::format("it was restarted with other settings: {}", difference_)};
  Peer anew{.run_id = message.run_id, .former_runs = peer.former_runs};
  anew.former_runs.push_back(peer.run_id);
  if (auto refused = refusal(anew, message)) return refused;
  if (rules_)
    if (auto refused = rules_->world_refusal(*peer.initial, message.window.front())) return refused;
  // What comes now is in time for our next boundary.
  if (!message.can_wait) anew.ahead = message.window.back().period - (published_ + 1);
  anew.bound = true;
  anew.can_wait = message.can_wait;
  peer = std::move(anew);
  counters_.add("world.restarted");
  return {};
}

void PeriodGate::accept(Peer& peer, KeptState state) {
  const std::int64_t period = state->period;
  if (period <= peer.received) return;  // known; a repetition changes nothing
  if (mode_ != Mode::free && period != peer.received + 1) return counters_.add("world.gap");
  peer.received = period;
  if (period == 0) peer.initial = state;
  if (!state->carried) {
    LabState whole = *state;
    repeat_payload(whole, *peer.states.rbegin()->second, rules_ ? rules_->fields() : std::vector<FieldRule>{});
    state = std::make_shared<const LabState>(std::move(whole));
  }
  const std::uint32_t number = state->period;
  peer.states.emplace(number, std::move(state));
  while (peer.states.size() > kept()) peer.states.erase(peer.states.begin());
}

void PeriodGate::decide_mode() {
  if (mode_ != Mode::undecided || published_ < 0) return;
  bool all_can_wait = options_.can_wait;
  for (const auto& [name, peer] : peers_) {
    if (peer.received < 0) return;
    all_can_wait = all_can_wait && peer.can_wait;
  }
  mode_ = all_can_wait ? Mode::strict : Mode::free;
}

bool PeriodGate::may_merge(std::uint32_t k) const {
  if (mode_ == Mode::undecided || published_ < static_cast<std::int64_t>(k)) return false;
  if (mode_ == Mode::free) return true;
  return received_from_all(wanted(k));
}

std::vector<MergedState> PeriodGate::merge(std::uint32_t k) {
  assert(may_merge(k));
  const std::int64_t want = wanted(k);
  std::vector<MergedState> merged;
  merged.reserve(options_.labs.size());
  auto next = peers_.begin();  // in the same order
  for (const std::string& lab : options_.labs) {
    if (lab == options_.lab) {
      const KeptState& own = own_.find(wanted(k))->second;
      merged.push_back({lab, own, k - want, k == 0 ? initial_ : nullptr, k - std::int64_t{payload_period(*own)}});
      continue;
    }
    Peer& peer = (next++)->second;
    // The newest at or before; in strict mode exactly `want`. What is older is needed no more.
    const std::int64_t theirs = k == 0 ? 0 : std::max<std::int64_t>(want + peer.ahead, 0);
    auto newest = peer.states.upper_bound(static_cast<std::uint32_t>(theirs));
    if (newest == peer.states.begin()) {  // a real-time arena ran so far ahead that its state for this boundary is gone
      counters_.add("gate.missing." + lab);
    } else {
      newest = peer.states.erase(peer.states.begin(), std::prev(newest));
    }
    const std::int64_t period = newest->first;
    if (period < theirs && k > 0) counters_.add("gate.late." + lab);
    if (period > peer.applied + 1)
      counters_.add("gate.skipped." + lab, static_cast<std::uint64_t>(period - peer.applied - 1));
    const std::int64_t now = k + peer.ahead;
    merged.push_back({lab, newest->second, now - period, peer.applied < 0 ? peer.initial : nullptr,
                      now - std::int64_t{payload_period(*newest->second)}});
    if (apply_event(peer, theirs, merged.back())) counters_.add("gate.early." + lab);
    peer.applied = std::max(peer.applied, period);
  }
  return merged;
}

bool PeriodGate::has_real_time_states(std::uint32_t k) const {
  if (mode_ != Mode::free || !options_.can_wait) return true;
  return std::all_of(peers_.begin(), peers_.end(),
                     [&](const auto& entry) { return entry.second.can_wait || has(entry.second, wanted(k)); });
}

bool PeriodGate::received_from_all(std::uint32_t period) const {
  return std::all_of(peers_.begin(), peers_.end(), [&](const auto& entry) { return has(entry.second, period); });
}

std::int64_t PeriodGate::received(std::string_view peer) const {
  return peers_.find(peer)->second.received;
}
bool PeriodGate::bound(std::string_view peer) const {
  return peers_.find(peer)->second.bound;
}
bool PeriodGate::done(std::string_view peer) const {
  return peers_.find(peer)->second.done;
}
std::int64_t PeriodGate::ended_at(std::string_view peer) const {
  const Peer& p = peers_.find(peer)->second;
  return p.done ? p.received - p.ahead : -1;
}
bool PeriodGate::acknowledged(std::string_view peer, std::uint32_t period) const {
  return peers_.find(peer)->second.acknowledged >= static_cast<std::int64_t>(period);
}
const LabState* PeriodGate::newest(std::string_view peer) const {
  const auto& states = peers_.find(peer)->second.states;
  return states.empty() ? nullptr : states.rbegin()->second.get();
}
const LabState* PeriodGate::initial(std::string_view peer) const {
  const Peer& p = peers_.find(peer)->second;
  return p.received < 0 ? nullptr : p.initial.get();
}
std::uint64_t PeriodGate::run_id(std::string_view peer) const {
  const auto it = peers_.find(peer);
  return it != peers_.end() && it->second.bound ? it->second.run_id : 0;
}

}  // namespace arkmesh::lab
