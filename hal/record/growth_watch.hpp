// Whether a recording grows faster than expected, and what makes it grow. Pure: the caller keeps the time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hal/text_map.hpp"

namespace arkmesh::hal {

class GrowthWatch {
 public:
  using Time = std::chrono::microseconds;

  explicit GrowthWatch(double most_bytes_per_s) : most_bytes_per_s_(most_bytes_per_s) {}

  struct Growth {
    double bytes_per_s;
    std::string channel;  // that had the most bytes
    double share;         // of all bytes, 0 to 1
  };
  // `bytes` more, at two clocks of which neither goes back. A simulation may be much faster than its lab time's clock,
  // and lab time stands while labs wait for each other: the clock that went further counts. What grew too fast is told
  // at the end of each 10 s.
  std::optional<Growth> add(Time lab, Time wall, std::string_view channel, std::size_t bytes);

 private:
  double most_bytes_per_s_;
  std::optional<Time> lab_, wall_;  // where the ten seconds began
  std::uint64_t all_ = 0;
  TextMap<std::uint64_t> by_channel_;
};

}  // namespace arkmesh::hal
