// Reads ids from LEDs while an audience of robots spells them: one digit after the other, all robots at once, so that
// the time it takes does not depend on their number. Knows tracks and colours only, not who is expected.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "hal/counters.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/id_code.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

struct ReadingTimes {
  // From a change of the question until pictures show the answer: two copies on the air (0.12 s), a robot's tick (0.03
  // s), the camera's latency (0.2 s).
  hal::LabTime settle{350'000};
  int pictures = 3;  // looked at per digit
};

class DigitReader {
 public:
  explicit DigitReader(ReadingTimes times, hal::Counters& counters) : times_(times), counters_(counters) {}

  // Begins to ask. What was read before stays, for tracks that were not read to the end: forget() what no longer holds.
  // Of `only` tracks what one of them at least has not been read of is asked; when there are none, everything.
  void ask(const Audience& audience, int digits, std::span<const TrackNumber> only = {});
  // The track may be another robot from now on.
  void forget(TrackNumber track) { votes_.erase(track); }
  void forget_all() { votes_.clear(); }

  // One picture of the arena; `now` is when it came, never decreasing.
  void on_frame(hal::LabTime now, std::span<const Track> tracks);

  bool asking() const { return position_ < to_ask_.size(); }
  const Audience& audience() const { return audience_; }
  // The digit in question and how many there are, for people who wait.
  int position() const { return static_cast<int>(position_); }
  int digits() const { return static_cast<int>(to_ask_.size()); }
  // Meaningful while asking.
  Question question() const { return digit_question(audience_, to_ask_[position_]); }

  struct Reading {
    TrackNumber track = 0;
    hal::RobotId robot = 0;
    float confidence = 0;  // share of pictures that agree, of the digit that fewest agree on
  };
  // Tracks that spelled an id without doubt, once asking is over. Forgets them. Others stay for the next time, except
  // those whose check word was wrong: these start anew. When only `candidates` were asked, a track of which some digits
  // could not be read is the one candidate that fits, if no other comes near.
  std::vector<Reading> take_readings(std::span<const hal::RobotId> candidates = {});

 private:
  using Votes = std::array<std::array<std::uint16_t, 3>, max_id_digits + check_digits>;  // by number of digit and digit
  std::vector<std::uint8_t> missing(std::span<const TrackNumber> tracks) const;
  std::optional<hal::RobotId> fitting(std::span<const std::optional<std::uint8_t>> digits,
                                      std::span<const hal::RobotId> candidates) const;

  ReadingTimes times_;
  hal::Counters& counters_;
  Audience audience_;
  std::span<const std::uint8_t> order_;   // of a whole spelling
  std::vector<std::uint8_t> to_ask_;      // of it, in that order
  std::size_t position_ = 0;              // in to_ask_
  std::optional<hal::LabTime> asked_at_;  // the digit in question
  int pictures_ = 0;                      // looked at for it
  std::map<TrackNumber, Votes> votes_;
};

}  // namespace arkmesh::tracker
