#include "app/live/status_news.hpp"

#include <fmt/format.h>

#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/bus/bus.hpp"
#include "hal/bus/loss.hpp"
#include "hal/label.hpp"

namespace arkmesh::app {
namespace {

constexpr std::size_t longest_state = 200, longest_counter = 80;
constexpr std::string_view counted = "counts.";

}  // namespace

std::vector<std::string> StatusNews::read(std::span<const std::byte> bytes) {
  std::vector<std::string> lines;
  lab_status_t status;
  if (!hal::decode(bytes, status)) return lines;
  stamp_us_ = status.stamp_us;
  lab_ = hal::printable(status.lab, hal::max_lab_name);
  std::string state = hal::printable(status.state, longest_state);
  if (state != state_) lines.push_back(state);
  state_ = std::move(state);
  counts_ = {};
  for (const counter_t& counter : status.counters) {
    if (counter.value >= 0 && counter.name.starts_with(counted))
      counts_.set(hal::printable(std::string_view(counter.name).substr(counted.size()), longest_counter),
                  static_cast<std::uint64_t>(counter.value));
    if (counter.value <= 0 || losses_.size() >= max_losses || !hal::is_loss(counter.name)) continue;
    const std::string name = hal::printable(counter.name, longest_counter);
    if (losses_.insert(name).second) lines.push_back(fmt::format("first loss: {} {}", counter.value, name));
  }
  return lines;
}

}  // namespace arkmesh::app
