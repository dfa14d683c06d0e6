// The payload of a state: robots and fields. Where labs do not exchange a new one each period, a state repeats the
// newest one, and on the wire names the boundary at which that was made.
#pragma once

#include <cstdint>
#include <vector>

#include "lab/exchange/exchange.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/exchange/state_rules.hpp"

namespace arkmesh::lab {

// The boundary at which the robots and fields of a state were made. It stands for their revision: it only grows.
inline std::uint32_t payload_period(const LabState& state) {
  return state.made_at.value_or(state.period);
}

// Of all labs, in the order of names, as applied_rule() tells it.
std::vector<std::int64_t> payload_periods(const std::vector<MergedState>& merged);

// Leaves out what the receiver knows; its period stays.
void leave_out_payload(LabState& state);
// The counterpart: `known` is the state before, which has the payload that is left out. Fields of state 0 only are not
// repeated.
void repeat_payload(LabState& state, const LabState& known, const std::vector<FieldRule>& rules);

// An event is a published field that has changed. Where robots walk is none, or every period would be one; so by events
// peers see robots where they were at the last event. A lab that publishes no changing field has nothing to tell but
// its robots: there a robot whose LED has changed is an event.
//
// Of the own lab: which payload the state of a boundary carries. A function of the states that it is given.
class OwnPayload {
 public:
  OwnPayload(const Exchange& exchange, bool is_owner);

  // `own`, with what is so at this boundary, keeps that when it is time, or repeats the newest payload. In order.
  void settle(LabState& own, const std::vector<FieldRule>& rules);
  // Between boundaries, by events: whether peers are to be told at once of what is so now. Then they were.
  bool tell_early(const LabState& now, const std::vector<FieldRule>& rules);
  bool by_events() const { return by_events_; }

 private:
  bool is_due(const LabState& own, const std::vector<FieldRule>& rules) const;

  bool by_events_;
  std::uint32_t every_;
  LabState newest_;  // that had a payload of its own
  LabState told_;    // what peers were told last, at a boundary or early
};

}  // namespace arkmesh::lab
