#include "scenarios/cre/swarm_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace arkmesh::scenarios::cre {
namespace {

double share(int part, int all) {
  return all == 0 ? 0 : static_cast<double>(part) / all;
}

std::uint64_t milliseconds(hal::LabTime t) {
  return static_cast<std::uint64_t>(t.count() / 1000);
}

}  // namespace

void Swarms::add_ground(const hal::Pose& in_ground, double height_m) {
  ++ground;
  ground_south += region_of(in_ground) == Region::south;
  ground_middle += std::abs(in_ground.y_m) < height_m / 8;
  const double band = std::floor((in_ground.y_m / height_m + 0.5) * static_cast<double>(bands.size()));
  ++bands[static_cast<std::size_t>(std::clamp(band, 0.0, static_cast<double>(bands.size()) - 1))];
}

void SwarmFigures::add(const Swarms& now) {
  const int flying = now.uncommitted + now.committed[0] + now.committed[1];
  const auto consensus_for = [&](Region region) {
    const int needed = static_cast<int>(std::ceil(consensus_ * flying - 1e-9));
    return flying > 0 && now.committed[index(region)] >= needed;
  };
  if (!region_) {
    middle_peak_ = std::max(middle_peak_, share(now.ground_middle, now.ground));
    for (Region region : both_regions)
      if (consensus_for(region)) {
        region_ = region;
        consensus_at_ = now.time;
      }
  }
  if (region_) {
    ++since_;
    held_ += consensus_for(*region_);
    const int there = *region_ == Region::south ? now.ground_south : now.ground - now.ground_south;
    if (!followed_at_ && now.ground > 0 && share(there, now.ground) >= 0.9) followed_at_ = now.time;
  }
  newest_.push_back({now.time, share(now.ground_south, now.ground), share(now.committed[0], flying),
                     share(now.committed[1], flying)});
  while (now.time - newest_.front().time >= window_) newest_.pop_front();
}

void SwarmFigures::tell(hal::Counters& counts) const {
  const auto mean = [&](double Shares::*of) {
    double sum = 0;
    for (const Shares& shares : newest_) sum += shares.*of;
    return newest_.empty() ? 0 : sum / static_cast<double>(newest_.size());
  };
  const auto ppm = [&](const char* name, double value) {
    counts.set(name, static_cast<std::uint64_t>(std::llround(value * 1e6)));
  };
  ppm("ground.middle_peak_ppm", middle_peak_);
  ppm("ground.south_ppm", mean(&Shares::ground_south));
  ppm("flying.north_ppm", mean(&Shares::flying_north));
  ppm("flying.south_ppm", mean(&Shares::flying_south));
  counts.set("consensus.north", region_ == Region::north ? 1 : 0);
  counts.set("consensus.south", region_ == Region::south ? 1 : 0);
  if (region_) {
    counts.set("consensus.ms", milliseconds(consensus_at_));
    counts.set("consensus.periods", since_);
    counts.set("consensus.held", held_);
  }
  if (followed_at_) counts.set("ground.followed_ms", milliseconds(*followed_at_));
}

std::string swarms_header() {
  std::string header = "period,time_s,uncommitted,north,south,ground,ground_south";
  for (std::size_t band = 0; band < Swarms().bands.size(); ++band) header += fmt::format(",band_{}", band);
  return header + ",harvested_north,harvested_south";
}

std::string swarms_row(const Swarms& now, std::uint32_t period, const std::vector<std::int64_t>& harvested) {
  std::string row = fmt::format("{},{:.1f},{},{},{},{},{}", period, static_cast<double>(now.time.count()) * 1e-6,
                                now.uncommitted, now.committed[0], now.committed[1], now.ground, now.ground_south);
  for (int band : now.bands) row += fmt::format(",{}", band);
  for (std::int64_t region : harvested) row += fmt::format(",{}", region);
  return row;
}

}  // namespace arkmesh::scenarios::cre
