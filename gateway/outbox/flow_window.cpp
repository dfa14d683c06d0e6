// After each timed byte: as large as what arrives in good time at the pace since, at most twice as large as before;
// smaller in proportion when the byte was late.
#include "gateway/outbox/flow_window.hpp"

#include <algorithm>

namespace arkmesh::gateway {

void FlowWindow::sent(std::size_t bytes, Time now) {
  if (under_way() == 0) progress_ = now;
  sent_ += bytes;
  // The byte that fills the window says most: all before it will be acknowledged until then.
  const bool filled = under_way() >= window_;
  if (!sample_ || (filled && !sample_->filled)) sample_ = {sent_, acknowledged_, now, filled};
}

bool FlowWindow::acknowledged(std::uint64_t total, Time now) {
  if (total > sent_ || total < acknowledged_) return false;
  if (total > acknowledged_) progress_ = now;
  acknowledged_ = total;
  if (sample_ && total >= sample_->total) {
    adapt(*sample_, now - sample_->sent);
    sample_.reset();
  }
  return true;
}

void FlowWindow::adapt(const Sample& sample, std::chrono::duration<double> delay) {
  path_ = std::min(path_, delay);
  const auto aim = this->aim();
  const std::size_t least = std::min(least_bytes, limits_.bytes);
  if (delay > aim) {
    window_ = std::max(least, static_cast<std::size_t>(static_cast<double>(window_) * (aim / delay)));
  } else if (sample.filled) {
    // So much would have been acknowledged in the time that is aimed at.
    const double full = static_cast<double>(acknowledged_ - sample.acknowledged) * (aim / delay);
    window_ = std::max(
        window_, static_cast<std::size_t>(std::min(full, static_cast<double>(std::min(limits_.bytes, 2 * window_)))));
  }
}

}  // namespace arkmesh::gateway
