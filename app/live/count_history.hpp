// What a lab's scenario has counted since its run began, as curves for the page. Bounded: of a long run every second,
// fourth, ... moment is kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::app {

class CountHistory {
 public:
  // Moments that are kept, and names; further names have no curve, and the page shows their newest value alone.
  static constexpr std::size_t max_moments = 1000, max_names = 50;

  // What was counted up to lab time `t_us`, microseconds. A time before the last one: the lab began anew, and so do the
  // curves.
  void note(std::int64_t t_us, const hal::Counters& counts);
  // A row {"name": "LAB NAME", "t_s": [...], "y": [...]} for each name; who was counted later than others had nothing
  // before.
  nlohmann::json series(std::string_view lab) const;

 private:
  std::vector<double> t_s_;
  std::map<std::string, std::vector<std::uint64_t>, std::less<>> curves_;
  std::int64_t newest_us_ = -1;
  std::uint64_t noted_ = 0, every_ = 1;  // one of so many moments is kept
};

}  // namespace arkmesh::app
