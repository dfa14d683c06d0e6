// A chained hash over what a lab's robots and sites did. Settings never enter that one, so two runs differ only through
// behaviour; they have one of their own (OwnState::settings_hash).
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "hal/random.hpp"
#include "hal/types.hpp"

namespace arkmesh::lab {

class BehaviourHash {
 public:
  void add(std::uint64_t word) { value_ = hal::mix64((value_ ^ word) + 0x9e3779b97f4a7c15ULL); }
  // Poses in micrometres and microradians, LED, id.
  void add(const hal::PoseFrame& frame);
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0;
};

// The labs' hashes in name order as one.
std::uint64_t joint_hash(const std::map<std::string, std::uint64_t>& by_lab);

// Metres to whole micrometres, radians to whole microradians; out of int32 saturates.
std::int32_t to_micro(double value);

}  // namespace arkmesh::lab
