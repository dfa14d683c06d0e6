// Keeps the book of which track is which robot: finds out when it begins, doubts when tracks meet, vanish or were
// hidden, and asks again only the robots that are unaccounted for, while the others go on. Pure: time and pictures come
// in, questions and names go out.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/digit_reader.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

struct IdentitySettings {
  std::vector<hal::RobotId> expected;  // ascending, each at most 65534; empty: whoever answers
  hal::RobotId largest = 1022;         // when nobody in particular is expected
  ReadingTimes times;
  hal::LabTime blind{800'000};   // a track that was not truly seen for so long may be another robot afterwards
  hal::LabTime calm{500'000};    // robots in question are seen so long before they are asked: no hand is among them
  hal::LabTime ending{600'000};  // how long robots are told that it is over
  hal::LabTime longest_pause{30'000'000};  // between questions that nobody new answers; they begin 2 s apart
};

struct Naming {
  TrackNumber track = 0;
  hal::RobotId robot = 0;
  float confidence = 0;  // 0..1
};

class IdentityKeeper {
 public:
  explicit IdentityKeeper(IdentitySettings settings);

  // One picture of the arena: all tracks, those predicted but not seen too (Track::age says so). A track that is not
  // there any more is gone. A `doubtful` track has no name for now; whoever sets it clears it when take_namings() names
  // the track anew, or earlier, `robot` unchanged, when the doubt turned out to be none. `now` never decreases.
  void on_frame(hal::LabTime now, std::span<const Track> tracks);

  // The broadcast that robots should hear now, over and over; nothing when there is no question.
  std::optional<Question> question() const;
  // Since the last call.
  std::vector<Naming> take_namings() { return std::exchange(namings_, {}); }

  // Nothing while there is any doubt.
  std::optional<hal::RobotId> robot_of(TrackNumber track) const;
  // Expected or once named, and no track is surely theirs: nothing may be said to them. Ascending.
  std::span<const hal::RobotId> doubtful() const { return unaccounted_; }
  // Everybody expected has a track; when nobody in particular is expected: every track has a name.
  bool everybody_named() const;
  // The robot's LED answers a question, or may still: it is no state of its program.
  bool led_is_answer(TrackNumber track) const;
  // Nobody is being asked and nobody will be as long as nothing changes; or nobody new has answered for `passes` rounds
  // of questions.
  bool settled(int passes) const;

  // For people who wait.
  struct Progress {
    int digit = 0, digits = 0;  // 0 of 0: nobody is asked
    int passes = 0;             // rounds of questions begun
    int named = 0, tracks = 0;
  };
  Progress progress() const;
  // Ids that several tracks spelled in the last round of questions: they have to be assigned anew. Ascending.
  std::span<const hal::RobotId> duplicates() const { return duplicates_; }
  // Ids that were spelled without doubt but are not expected. Ascending.
  std::span<const hal::RobotId> strangers() const { return strangers_; }
  const hal::Counters& counters() const { return counters_; }

 private:
  struct Entry {
    std::optional<hal::RobotId> robot;
    bool doubted = false;  // `robot` may turn out right
    bool seen = false;     // in this picture
    std::optional<hal::LabTime> seen_since;
    bool sure() const { return robot && !doubted; }
    void unname() { robot.reset(), doubted = false; }
  };

  void update_book(hal::LabTime now, std::span<const Track> tracks);
  void update_unaccounted();
  bool worth_asking(hal::LabTime now) const;
  void ask();
  void use_readings(hal::LabTime now);
  int digits_needed(const Audience& audience) const;

  IdentitySettings settings_;
  hal::Counters counters_;
  DigitReader reader_;
  std::map<TrackNumber, Entry> book_;
  std::vector<hal::RobotId> known_;  // expected, or once named; ascending
  std::vector<hal::RobotId> unaccounted_, duplicates_, strangers_;
  std::vector<Naming> namings_;
  bool asked_ = false;       // a round of questions is under way
  bool asked_part_ = false;  // of those who are missed, in the latest round
  bool began_ = false;       // the first one is over with everybody named, or as many as will answer
  std::optional<hal::LabTime> tell_end_until_;
  hal::LabTime not_before_{0};
  int passes_ = 0, barren_passes_ = 0;
  std::size_t turn_ = 0;
  hal::LabTime now_{0};
};

}  // namespace arkmesh::tracker
