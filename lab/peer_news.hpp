// When a new state of any peer was applied last. Robots that nobody holds back by waiting do not go on for long without
// one. The caller owns time.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lab/merged_state.hpp"

namespace arkmesh::lab {

class PeerNews {
 public:
  using Now = std::chrono::microseconds;

  // `limit`: how long may be none; none: for ever.
  PeerNews(std::string lab, std::optional<Now> limit) : lab_(std::move(lab)), limit_(limit) {}

  // What was applied at a boundary.
  void note(const std::vector<MergedState>& merged, Now now);
  // For how long there has been none, when that is too long. To be called at every step: time in which the lab itself
  // stood still does not count, for what came meanwhile is only about to be applied.
  std::optional<Now> silence(Now now);

 private:
  const std::string lab_;
  const std::optional<Now> limit_;
  std::map<std::string, std::uint32_t> newest_;  // period, by peer
  std::optional<Now> last_;                      // nothing before robots move
  Now looked_{0};
};

}  // namespace arkmesh::lab
