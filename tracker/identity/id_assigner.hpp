// Gives robots ids of their own, whatever ids they have: lets them draw temporary ids by chance, reads these, has those
// that were drawn twice drawn anew, tells each temporary id its new one, and reads everybody again. The robots run
// hal/platforms/kilobot/firmware/assign_ids.c. Pure: time and pictures come in, broadcasts go out.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/identity/announcements.hpp"
#include "tracker/identity/digit_reader.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

inline constexpr hal::RobotId first_temporary_id = 0x8000;

struct AssignmentSettings {
  std::vector<hal::RobotId> ids;  // to give, in this order, each once and below first_temporary_id
  std::uint8_t session = 1;       // another one for each assignment: robots draw once per session
  ReadingTimes times;
  int max_rounds = 6;  // of drawing, and of storing, until the rest is given up
};

class IdAssigner {
 public:
  enum class Phase : std::uint8_t { drawing, reading, storing, checking, ending, finished };
  enum class Outcome : std::uint8_t { unread, drawn, given, confirmed, no_id_left };

  explicit IdAssigner(AssignmentSettings settings);

  // One picture of the arena; `now` never decreases. Robots that are not seen any more get nothing.
  void on_frame(hal::LabTime now, std::span<const Track> tracks);
  std::optional<Question> question() const;

  Phase phase() const { return phase_; }
  bool finished() const { return phase_ == Phase::finished; }

  struct Robot {
    hal::Pose in_arena;  // when last seen
    std::optional<hal::RobotId> temporary;
    std::optional<hal::RobotId> given;  // its id once it is confirmed
    Outcome outcome = Outcome::unread;
  };
  // By track, those in the newest picture.
  const std::map<TrackNumber, Robot>& robots() const { return robots_; }

  // For people who wait: how far the phase is.
  struct Progress {
    int round = 1;
    int done = 0, of = 0;  // digits, or robots told
    int confirmed = 0;
  };
  Progress progress() const;
  const hal::Counters& counters() const { return counters_; }

 private:
  void update_robots(std::span<const Track> tracks);
  void use_drawn();
  void give_ids();
  void announce_ids();
  void use_checked();
  void read(Phase phase);

  AssignmentSettings settings_;
  hal::Counters counters_;
  DigitReader reader_;
  Announcements announcements_;
  Phase phase_ = Phase::drawing;
  std::map<TrackNumber, Robot> robots_;
  std::size_t next_id_ = 0;  // of settings_.ids
  int round_ = 1;
  std::size_t announced_ = 0;
};

std::string_view name_of(IdAssigner::Phase phase);
std::string_view name_of(IdAssigner::Outcome outcome);

}  // namespace arkmesh::tracker
