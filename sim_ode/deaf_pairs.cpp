#include "sim_ode/deaf_pairs.hpp"

#include <algorithm>

namespace arkmesh::sim_ode {
namespace {

constexpr std::int64_t long_us = 60'000'000;

}  // namespace

void DeafPairs::add(const Pair& pair, Totals& totals) {
  if (pair.until_us - pair.since_us < long_us) return;
  ++totals.in_reach;
  totals.deaf += !pair.heard;
}

// Before the sender's listeners are named: who was not named the last time has parted.
void DeafPairs::look(std::size_t number, std::int64_t at_us) {
  Sender& sender = senders_[sender_ = number];
  std::erase_if(sender.pairs, [&](const Pair& pair) {
    const bool parted = pair.until_us < sender.looked_us;
    if (parted) {
      add(pair, parted_);
      sender.unheard -= !pair.heard;
    }
    return parted;
  });
  if (sender.unheard == 0) states_[number] &= static_cast<std::uint8_t>(~waits);
  sender.looked_us = at_us;
  next_ = 0;
}

void DeafPairs::reaches(int listener) {
  auto& [looked_us, unheard, pairs] = senders_[sender_];
  // mostly they are named in the same order as the last time
  if (next_ >= pairs.size() || pairs[next_].listener != listener)
    next_ = static_cast<std::size_t>(std::ranges::find(pairs, listener, &Pair::listener) - pairs.begin());
  if (next_ == pairs.size()) {
    pairs.push_back({listener, false, looked_us, looked_us});
    ++unheard;
    states_[sender_] |= waits;
  }
  pairs[next_++].until_us = looked_us;
}

void DeafPairs::hears(int number, int listener) {
  Sender& sender = senders_[static_cast<std::size_t>(number)];
  const auto pair = std::ranges::find(sender.pairs, listener, &Pair::listener);
  if (pair == sender.pairs.end() || pair->heard) return;
  pair->heard = true;
  if (--sender.unheard == 0) states_[static_cast<std::size_t>(number)] &= static_cast<std::uint8_t>(~waits);
}

DeafPairs::Totals DeafPairs::totals() const {
  Totals out = parted_;
  for (const Sender& sender : senders_)
    for (const Pair& pair : sender.pairs) add(pair, out);
  return out;
}

}  // namespace arkmesh::sim_ode
