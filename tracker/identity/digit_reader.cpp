#include "tracker/identity/digit_reader.hpp"

#include <algorithm>

namespace arkmesh::tracker {
namespace {

// What pictures say of one digit: two at least, and two thirds of all.
struct Read {
  std::uint8_t digit = 0;
  int agree = 0, all = 0;
  bool clear() const { return agree >= 2 && 3 * agree >= 2 * all; }
};

Read read_of(const std::array<std::uint16_t, 3>& votes) {
  const auto most = std::max_element(votes.begin(), votes.end());
  return {static_cast<std::uint8_t>(most - votes.begin()), *most, votes[0] + votes[1] + votes[2]};
}

}  // namespace

void DigitReader::ask(const Audience& audience, int digits, std::span<const TrackNumber> only) {
  audience_ = audience;
  const auto order = digit_order(digits);
  // other digits are another spelling
  if (order.size() != order_.size()) votes_.clear();
  order_ = order;
  to_ask_ = missing(only);
  position_ = 0;
  pictures_ = 0;
  asked_at_.reset();
}

void DigitReader::on_frame(hal::LabTime now, std::span<const Track> tracks) {
  if (!asking()) return;
  if (!asked_at_) asked_at_ = now;
  if (now - *asked_at_ < times_.settle) return;

  for (const Track& track : tracks) {
    if (!track.led_seen && track.primary_confidence == 0) continue;
    if (const auto digit = digit_of(answer_of(track))) {
      std::uint16_t& votes = votes_[track.number][to_ask_[position_]][*digit];
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

// Who was seen too late, or lit badly for a while, needs the rest only. A whole spelling when nothing is missing:
// somebody was not believed, and has to say it again.
std::vector<std::uint8_t> DigitReader::missing(std::span<const TrackNumber> tracks) const {
  std::vector<std::uint8_t> out;
  for (const std::uint8_t digit : order_) {
    const bool lacks = std::any_of(tracks.begin(), tracks.end(), [&](TrackNumber track) {
      const auto at = votes_.find(track);
      return at == votes_.end() || !read_of(at->second[digit]).clear();
    });
    if (lacks) out.push_back(digit);
  }
  if (out.empty()) out.assign(order_.begin(), order_.end());
  return out;
}

std::vector<DigitReader::Reading> DigitReader::take_readings(std::span<const hal::RobotId> candidates) {
  std::vector<Reading> out;
  std::vector<std::optional<std::uint8_t>> read(order_.size());
  std::vector<std::uint8_t> digits(order_.size());
  for (auto at = votes_.begin(); at != votes_.end();) {
    Reading reading{.track = at->first, .confidence = 1};
    std::size_t known = 0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Read one = read_of(at->second[order_[i]]);
      read[i].reset();
      if (!one.clear()) continue;
      ++known;
      read[i] = digits[i] = one.digit;
      reading.confidence = std::min(reading.confidence, static_cast<float>(one.agree) / static_cast<float>(one.all));
    }
    const bool complete = known == order_.size();
    const auto robot = complete ? id_of(digits) : fitting(read, candidates);
    if (robot) {
      reading.robot = *robot;
      reading.confidence *= static_cast<float>(known) / static_cast<float>(order_.size());
      out.push_back(reading);
    } else {
      counters_.add(complete ? "identity.refused.check_word" : "identity.unread.digits");
    }
    at = robot || complete ? votes_.erase(at) : std::next(at);
  }
  return out;
}

// The candidate that contradicts nothing that was read, while all others do in two places. Five digits must have been
// read, and the colour must have changed as programs do not change it in these seconds.
std::optional<hal::RobotId> DigitReader::fitting(std::span<const std::optional<std::uint8_t>> digits,
                                                 std::span<const hal::RobotId> candidates) const {
  constexpr int min_read = 5, min_changes = 2, min_against_others = 2;
  int known = 0, changes = 0;
  std::optional<std::uint8_t> before;
  for (const auto& digit : digits) {
    if (!digit) continue;
    ++known;
    changes += before && before != digit;
    before = digit;
  }
  if (known < min_read || changes < min_changes) return std::nullopt;
  std::optional<hal::RobotId> out;
  for (const hal::RobotId robot : candidates) {
    if (robot > largest_spelled_id) continue;
    int against = 0;
    for (std::size_t i = 0; i < digits.size(); ++i)
      against += digits[i] && digits[i] != digit_of(spelled(robot, order_[i]));
    if (against > 0 && against < min_against_others) return std::nullopt;
    if (against > 0) continue;
    if (out) return std::nullopt;
    out = robot;
  }
  return out;
}

}  // namespace arkmesh::tracker
