#include "gateway/outbox/ordered_inbox.hpp"

#include <algorithm>
#include <utility>

namespace arkmesh::gateway {

std::uint64_t OrderedInbox::begin() {
  const std::uint64_t settled = settled_.value_or(announced_);
  const std::uint64_t missing = announced_ - std::min(announced_, settled);
  if (missing > 0) counters_.add("received.missing.restart", missing);
  newest_.clear();
  announced_ = came_before_ = 0;
  settled_.reset();
  return missing;
}

bool OrderedInbox::take(std::string_view channel, std::uint64_t sequence) {
  if (sequence == 0) return true;
  const auto found = newest_.find(channel);
  std::uint64_t settled = 1;
  if (found == newest_.end()) {
    // A peer that lists patterns may send any names.
    if (newest_.size() == max_channels) {
      counters_.add("received.refused.too_many_channels");
      return false;
    }
    newest_.emplace(channel, sequence);
  } else if (sequence <= found->second) {
    counters_.add("received.repeated." + found->first);
    return false;
  } else {
    settled = sequence - std::exchange(found->second, sequence);
    if (settled > 1) counters_.add("received.missing." + found->first, settled - 1);
  }
  (settled_ ? *settled_ : came_before_) += settled;
  return true;
}

void OrderedInbox::announced(std::uint64_t accepted, std::uint64_t pending) {
  announced_ = accepted;
  if (!settled_) settled_ = accepted - std::min(accepted, pending) + came_before_;
}

}  // namespace arkmesh::gateway
