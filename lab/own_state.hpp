// What a lab owns, and the hash of its behaviour so far: gathers pose frames, and makes the own state of each boundary.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "hal/types.hpp"
#include "lab/behaviour_hash.hpp"
#include "lab/lab_data.hpp"
#include "lab/lab_state.hpp"

namespace arkmesh::lab {

class OwnState {
 public:
  // `settings`: what all labs must have alike; part of state 0.
  explicit OwnState(std::map<std::string, std::string, std::less<>> settings) : settings_(std::move(settings)) {}

  // The newest frame: its robots are those of the next state.
  void add(const hal::PoseFrame& frame);
  const hal::PoseFrame& frame() const { return frame_; }

  // State `period`. Call once per boundary, in order. Declared fields and random streams of `lab` become part of the
  // hash.
  LabState at_boundary(std::uint32_t period, const LabData& lab);
  // Of all frames and boundaries so far.
  std::uint64_t hash() const { return hash_.value(); }

 private:
  std::map<std::string, std::string, std::less<>> settings_;
  hal::PoseFrame frame_;
  BehaviourHash hash_;
};

}  // namespace arkmesh::lab
