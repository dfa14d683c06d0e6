#include "sim_ode/deaf_pairs.hpp"

#include <algorithm>
#include <bit>

namespace arkmesh::sim_ode {
namespace {

constexpr std::int64_t long_us = 60'000'000;
constexpr std::size_t least_width = 64, most_width = 1024;

}  // namespace

DeafPairs::DeafPairs(int robots)
    : width_(std::clamp(std::bit_ceil(static_cast<std::size_t>(robots)), least_width, most_width)),
      heard_(static_cast<std::size_t>(robots) * width_ / 64),
      senders_(static_cast<std::size_t>(robots)) {}

void DeafPairs::add(const Pair& pair, Totals& totals) {
  if (pair.until_us - pair.since_us < long_us) return;
  ++totals.in_reach;
  totals.deaf += !pair.heard;
}

// Before the sender's listeners are named: who was not named the last time has parted; what the others have heard
// since.
void DeafPairs::look(std::int64_t at_us) {
  Sender& sender = senders_[sender_];
  std::erase_if(sender.pairs, [&](const Pair& pair) {
    const bool parted = pair.until_us < sender.looked_us;
    if (parted) add(pair, parted_);
    return parted;
  });
  for (Pair& pair : sender.pairs) {
    const std::size_t bit = bit_of(sender_, pair.listener);
    pair.heard |= (heard_[bit / 64] >> bit % 64 & 1) != 0;
  }
  std::fill_n(heard_.begin() + static_cast<std::ptrdiff_t>(sender_ * width_ / 64), width_ / 64, 0);
  sender.looked_us = at_us;
  next_ = 0;
}

void DeafPairs::reaches(int listener) {
  auto& [messages, looked_us, pairs] = senders_[sender_];
  // mostly they are named in the same order as the last time
  if (next_ >= pairs.size() || pairs[next_].listener != listener)
    next_ = static_cast<std::size_t>(std::ranges::find(pairs, listener, &Pair::listener) - pairs.begin());
  if (next_ == pairs.size()) pairs.push_back({listener, false, looked_us, looked_us});
  pairs[next_++].until_us = looked_us;
}

DeafPairs::Totals DeafPairs::totals() const {
  Totals out = parted_;
  for (const Sender& sender : senders_)
    for (const Pair& pair : sender.pairs) add(pair, out);
  return out;
}

}  // namespace arkmesh::sim_ode
