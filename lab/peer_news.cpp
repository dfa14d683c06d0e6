#include "lab/peer_news.hpp"

#include <algorithm>
#include <utility>

namespace arkmesh::lab {
namespace {

using namespace std::chrono_literals;

constexpr PeerNews::Now stood_still_after = 3s;  // without a look

}  // namespace

void PeerNews::note(const std::vector<MergedState>& merged, Now now) {
  bool news = !last_;
  for (const MergedState& one : merged) {
    if (one.lab == lab_ || !one.state) continue;
    const auto [it, first] = newest_.try_emplace(one.lab, one.state->period);
    news = news || first || one.initial || one.state->period > it->second;
    it->second = one.state->period;
  }
  if (news) last_ = now;
}

std::optional<PeerNews::Now> PeerNews::silence(Now now) {
  const Now away = now - std::exchange(looked_, now);
  if (!limit_ || !last_) return {};
  if (away > stood_still_after) last_ = std::min(*last_ + away, now);
  return now - *last_ > *limit_ ? std::optional(now - *last_) : std::nullopt;
}

}  // namespace arkmesh::lab
