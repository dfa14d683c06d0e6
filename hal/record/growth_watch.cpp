#include "hal/record/growth_watch.hpp"

#include <algorithm>

namespace arkmesh::hal {

using namespace std::chrono_literals;

constexpr GrowthWatch::Time watched = 10s;
constexpr std::size_t most_watched_channels = 256;  // anybody makes up names

std::optional<GrowthWatch::Growth> GrowthWatch::add(Time lab, Time wall, std::string_view channel, std::size_t bytes) {
  if (!lab_) lab_ = lab, wall_ = wall;
  all_ += bytes;
  auto found = by_channel_.find(channel);
  if (found == by_channel_.end() && by_channel_.size() < most_watched_channels)
    found = by_channel_.emplace(channel, 0).first;
  if (found != by_channel_.end()) found->second += bytes;

  const Time passed = std::max(lab - *lab_, wall - *wall_);
  if (passed < watched) return {};
  const double bytes_per_s = static_cast<double>(all_) / std::chrono::duration<double>(passed).count();
  std::optional<Growth> growth;
  if (bytes_per_s > most_bytes_per_s_) {
    const auto most = std::ranges::max_element(by_channel_, {}, [](const auto& entry) { return entry.second; });
    growth = Growth{bytes_per_s, most->first, static_cast<double>(most->second) / static_cast<double>(all_)};
  }
  *this = GrowthWatch(most_bytes_per_s_);
  return growth;
}

}  // namespace arkmesh::hal
