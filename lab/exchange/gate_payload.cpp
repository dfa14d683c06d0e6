// The part of the period gate that knows that a state's robots and fields may be those of an earlier boundary, or come
// early as an event.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "lab/exchange/payload.hpp"
#include "lab/exchange/period_gate.hpp"

namespace arkmesh::lab {

// A payload is in a message once, in the first state that has it, and no more when every peer has it: a peer tells that
// it has a state only if it has what that state repeats.
void PeriodGate::leave_out_known(std::vector<LabState>& window) const {
  if (options_.exchange.plain()) return;
  const std::int64_t needless = options_.until_confirmed ? std::min(acknowledged(), confirmed_) : acknowledged();
  std::int64_t told = needless;
  for (LabState& state : window) {
    const std::int64_t made = payload_period(state);
    if (made <= told)
      leave_out_payload(state);
    else
      told = made;
  }
}

void PeriodGate::publish_early(LabState event) {
  const std::uint32_t number = event_ ? event_->number + 1 : 1;
  event_ = EarlyEvent{number, std::move(event)};
}

// `known`: the boundary at which the newest payload was made that the receiver has when it comes to this state.
std::optional<Refusal> PeriodGate::payload_refusal(const LabState& state, std::int64_t& known) {
  const std::int64_t made = payload_period(state);
  if (made < known || (!state.carried && made != known))
    return Refusal{
        "payload",
        fmt::format(
            "its state {} refers to the robots and fields of its state {}, but this lab has those of its state {}",
            state.period, made, known)};
  known = made;
  return {};
}

std::optional<Refusal> PeriodGate::event_refusal(const Peer& peer, const WorldMessage& message) const {
  if (!message.event) return {};
  const LabState& event = message.event->state;
  const auto because = [&](std::string sentence) { return Refusal{"event", std::move(sentence)}; };
  if (message.window.empty() || event.period != message.window.back().period + 1)
    return because(fmt::format("its event is from period {}, which is not its next", event.period));
  if (event.period > newest_of_peers() || !event.settings.empty())
    return because(fmt::format("its event is from period {}, in the future", event.period));
  if (!rules_) return {};
  const LabState* initial = peer.received >= 0 ? peer.initial.get() : nullptr;
  if (!initial && message.window.front().period == 0) initial = &message.window.front();
  if (!initial) return because("its event came before its state 0");
  return rules_->refusal(message.lab, event, *initial);
}

// Strict labs merge exactly the state of a boundary, so an event tells them nothing.
void PeriodGate::accept_event(Peer& peer, const EarlyEvent& event) {
  if (mode_ == Mode::strict) return counters_.add("world.event_ignored");
  if (peer.event &&
      std::pair(peer.event->state.period, peer.event->number) >= std::pair(event.state.period, event.number))
    return;
  peer.event = event;
}

// The newest event takes the place of older robots and fields, when it is of period `until` at the latest. The clock of
// the state stays.
bool PeriodGate::apply_event(const Peer& peer, std::int64_t until, MergedState& merged) {
  if (!peer.event) return false;
  const LabState& event = peer.event->state;
  if (event.period <= merged.state->period || event.period > until) return false;
  LabState with_event = *merged.state;
  with_event.robots = event.robots;
  with_event.fields = event.fields;
  merged.payload_age_periods = merged.age_periods + merged.state->period - event.period;
  merged.state = std::make_shared<const LabState>(std::move(with_event));
  return true;
}

std::int64_t PeriodGate::acknowledged() const {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (const auto& [name, peer] : peers_) least = std::min(least, peer.acknowledged);
  return least;
}

}  // namespace arkmesh::lab
