// How labs exchange what they own: gate.exchange and its two periods. The clock part of a state, its period and hash,
// goes every period in every mode; this says when a new payload, robots and fields, goes with it.
#pragma once

#include <cstdint>
#include <string>

#include "hal/config/config.hpp"
#include "hal/types.hpp"

namespace arkmesh::lab {

struct Exchange {
  enum class Mode {
    time,   // at whole multiples of a period
    event,  // when a published field has changed (payload.hpp)
    mixed,  // the owner's in time, the others' by event
  };
  Mode mode = Mode::time;
  // gate.up_period_s: of the labs that are not the owner; gate.down_period_s: of the owner. 0: as gate.period_s.
  hal::LabTime up{0}, down{0};
  std::uint32_t up_periods = 1, down_periods = 1;  // the same in periods

  void fields(const hal::Section& gate);
  // Throws ConfigError. `period`: gate.period_s.
  void check(const hal::Section& gate, hal::LabTime period);

  bool by_events(bool is_owner) const { return mode == Mode::event || (mode == Mode::mixed && !is_owner); }
  // In time: a new payload every so many periods.
  std::uint32_t every(bool is_owner) const { return is_owner ? down_periods : up_periods; }
  // Every state of every lab carries a payload of its own.
  bool plain() const { return mode == Mode::time && up_periods == 1 && down_periods == 1; }
  // After so many periods an event should have been confirmed: the way to the owner and back with its next snapshot,
  // and one more. 3 where slack is 0 and the owner tells each period.
  std::uint32_t confirmed_within(std::uint32_t slack) const { return 2 * slack + down_periods + 2; }
};

// "time", "event" or "mixed".
std::string name_of(Exchange::Mode mode);

}  // namespace arkmesh::lab
