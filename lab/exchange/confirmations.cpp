#include "lab/exchange/confirmations.hpp"

namespace arkmesh::lab {

void Confirmations::published(std::uint32_t period, bool is_event) {
  for (Event& event : waiting_)
    if (!event.overdue && period >= event.period + within_) {
      event.overdue = true;
      ++unconfirmed_;
    }
  if (!is_event) {
    // The newest payload is the one that is told again.
    if (!waiting_.empty() && waiting_.back().overdue) ++resent_;
    return;
  }
  ++told_;
  waiting_.push_back({period, false});
}

void Confirmations::shown(std::int64_t period) {
  while (!waiting_.empty() && static_cast<std::int64_t>(waiting_.front().period) <= period) {
    waiting_.pop_front();
    ++confirmed_;
  }
}

}  // namespace arkmesh::lab
