// The lines of a lab's event log that its status gives: what it is doing when that changes, and the first loss of each
// kind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::app {

class StatusNews {
 public:
  // Of a message on `status`, from whomever: what is no lab_status_t, or contradicts itself, gives nothing.
  std::vector<std::string> read(std::span<const std::byte> bytes);
  // Of the newest one. Lab time in microseconds; the lab's name, empty before the first.
  std::int64_t stamp_us() const { return stamp_us_; }
  const std::string& lab() const { return lab_; }
  // What its scenario has counted.
  const hal::Counters& counts() const { return counts_; }

 private:
  static constexpr std::size_t max_losses = 1000;

  std::int64_t stamp_us_ = 0;
  std::string lab_, state_;
  std::set<std::string> losses_;
  hal::Counters counts_;
};

}  // namespace arkmesh::app
