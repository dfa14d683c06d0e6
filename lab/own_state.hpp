// What a lab owns, and the hash of its behaviour so far: gathers pose frames, and makes the own state of each boundary.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "hal/types.hpp"
#include "lab/behaviour_hash.hpp"
#include "lab/exchange/lab_state.hpp"
#include "lab/exchange/payload.hpp"
#include "lab/lab_data.hpp"

namespace arkmesh::lab {

class OwnState {
 public:
  // `settings`: what all labs must have alike; part of state 0.
  // `exchange`: when robots and fields are told anew; `is_owner`: of the shared things.
  explicit OwnState(std::map<std::string, std::string, std::less<>> settings, const Exchange& exchange = {},
                    bool is_owner = true);

  // The newest frame: its robots are those of the next state.
  void add(const hal::PoseFrame& frame);
  const hal::PoseFrame& frame() const { return frame_; }

  // State `period`. Call once per boundary, in order. Declared fields and random streams of `lab` become part of the
  // hash.
  LabState at_boundary(std::uint32_t period, const LabData& lab);
  // Exchange by events, between boundaries: what is so now, as of the next one, when that is an event after what peers
  // were told last; none when it is not. Touches no hash.
  std::optional<LabState> event(const LabData& lab);
  // Equal where all settings are.
  std::uint64_t settings_hash() const { return settings_hash_; }
  // Of all frames and boundaries so far.
  std::uint64_t hash() const { return hash_.value(); }

 private:
  LabState payload_now(std::uint32_t period, const LabData& lab) const;

  std::map<std::string, std::string, std::less<>> settings_;
  std::uint64_t settings_hash_;
  OwnPayload payload_;
  std::uint32_t next_ = 0;  // period
  hal::PoseFrame frame_;
  BehaviourHash hash_;
};

}  // namespace arkmesh::lab
