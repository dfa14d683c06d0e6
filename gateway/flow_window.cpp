// Twice as large after each timed byte that was acknowledged in good time, smaller in proportion when it was late.
#include "gateway/flow_window.hpp"

#include <algorithm>

namespace arkmesh::gateway {

void FlowWindow::sent(std::size_t bytes, Time now) {
  if (under_way() == 0) progress_ = now;
  sent_ += bytes;
  if (!sample_) sample_ = {sent_, now, false};
  sample_->filled |= room() == 0;
}

bool FlowWindow::acknowledged(std::uint64_t total, Time now) {
  if (total > sent_ || total < acknowledged_) return false;
  if (total > acknowledged_) progress_ = now;
  acknowledged_ = total;
  if (sample_ && total >= sample_->total) {
    adapt(now - sample_->sent, sample_->filled);
    sample_.reset();
  }
  return true;
}

void FlowWindow::adapt(std::chrono::duration<double> delay, bool filled) {
  path_ = std::min(path_, delay);
  const std::chrono::duration<double> aim = path_ + limits_.delay;
  const std::size_t least = std::min(least_bytes, limits_.bytes);
  if (delay > aim)
    window_ = std::max(least, static_cast<std::size_t>(static_cast<double>(window_) * (aim / delay)));
  else if (filled)
    window_ = std::min(limits_.bytes, 2 * window_);
}

}  // namespace arkmesh::gateway
