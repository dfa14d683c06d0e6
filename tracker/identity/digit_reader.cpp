#include "tracker/identity/digit_reader.hpp"

#include <algorithm>

namespace arkmesh::tracker {

void DigitReader::ask(const Audience& audience, int digits) {
  audience_ = audience;
  const auto order = digit_order(digits);
  // other digits are another spelling
  if (order.size() != order_.size()) votes_.clear();
  order_ = order;
  position_ = 0;
  pictures_ = 0;
  asked_at_.reset();
}

void DigitReader::on_frame(hal::LabTime now, std::span<const Track> tracks) {
  if (!asking()) return;
  if (!asked_at_) asked_at_ = now;
  if (now - *asked_at_ < times_.settle) return;

  for (const Track& track : tracks) {
    if (!track.led_seen) continue;
    if (const auto digit = digit_of(track.led)) {
      std::uint16_t& votes = votes_[track.number][order_[position_]][*digit];
      if (votes < 1000) ++votes;
    } else {
      counters_.add("identity.ignored.colour");
    }
  }
  if (++pictures_ < times_.pictures) return;
  ++position_;
  pictures_ = 0;
  asked_at_ = now;
}

std::vector<DigitReader::Reading> DigitReader::take_readings() {
  std::vector<Reading> out;
  std::vector<std::uint8_t> digits(order_.size());
  for (auto at = votes_.begin(); at != votes_.end();) {
    Reading reading{.track = at->first, .confidence = 1};
    bool complete = true;
    for (std::size_t i = 0; i < order_.size() && complete; ++i) {
      const auto& votes = at->second[order_[i]];
      const auto most = std::max_element(votes.begin(), votes.end());
      const int all = votes[0] + votes[1] + votes[2], agree = *most;
      // two pictures at least, and two thirds of all
      complete = agree >= 2 && 3 * agree >= 2 * all;
      digits[i] = static_cast<std::uint8_t>(most - votes.begin());
      if (complete) reading.confidence = std::min(reading.confidence, static_cast<float>(agree) / static_cast<float>(all));
    }
    if (!complete) {
      counters_.add("identity.unread.digits");
      ++at;
      continue;
    }
    if (const auto robot = id_of(digits)) {
      reading.robot = *robot;
      out.push_back(reading);
    } else {
      counters_.add("identity.refused.check_word");
    }
    at = votes_.erase(at);
  }
  return out;
}

}  // namespace arkmesh::tracker
