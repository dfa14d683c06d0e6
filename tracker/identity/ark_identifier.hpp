// ARK's way to find out who is who, for robot programs that know no other: one id after the other is called (message
// 120 before an experiment, 119 during one); the robot whose id it is shows blue, all others red. Takes as long as
// there are ids. Ids have 16 bits here as the message has them; ARK itself keeps 8 of them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "hal/counters.hpp"
#include "tracker/identity/digit_reader.hpp"
#include "tracker/identity/identity_keeper.hpp"
#include "tracker/identity/question.hpp"

namespace arkmesh::tracker {

struct ArkSettings {
  std::vector<hal::RobotId> candidates;  // ascending; empty: 0 to `largest`
  hal::RobotId largest = 1022;
  bool runtime = false;  // message 119, not 120
  ReadingTimes times{.pictures = 5};
  hal::LabTime ending{600'000};  // how long robots are told that it is over
  int max_rounds = 3;            // through all candidates that have not been found
};

class ArkIdentifier {
 public:
  explicit ArkIdentifier(ArkSettings settings);

  // One picture of the arena with the tracks in question; `now` never decreases. Doubtful tracks and such as were not
  // seen for longer than 0.8 s lose what was found out about them.
  void on_frame(hal::LabTime now, std::span<const Track> tracks);
  std::optional<Question> question() const;
  // All at the end: until then an id may turn out to be called wrongly. Ascending by track.
  std::vector<Naming> take_namings() { return std::exchange(namings_, {}); }
  bool finished() const { return state_ == State::finished; }

  // Ids to which several robots answered in the last round. Ascending.
  const std::vector<hal::RobotId>& duplicates() const { return duplicates_; }
  // The id that is called and how many are named so far.
  std::optional<hal::RobotId> called() const;
  int named() const { return static_cast<int>(claims_.size()); }
  const hal::Counters& counters() const { return counters_; }

 private:
  enum class State : std::uint8_t { asking, ending, finished };
  struct Claim {
    hal::RobotId robot = 0;
    float confidence = 0;
  };
  struct Count {
    int blue = 0, other = 0;
  };

  void drop_unsure(std::span<const Track> tracks);
  void conclude(hal::LabTime now);
  void next_id(hal::LabTime now);

  ArkSettings settings_;
  hal::Counters counters_;
  State state_ = State::asking;
  std::vector<hal::RobotId> to_call_;  // this round's
  std::size_t position_ = 0;
  int round_ = 1;
  std::optional<hal::LabTime> asked_at_;
  int pictures_ = 0;
  std::size_t tracks_ = 0;               // in the newest picture
  std::map<TrackNumber, Count> counts_;  // for the id that is called
  std::map<TrackNumber, int> answers_;   // of this round; of those who answer to many, all
  std::map<TrackNumber, Claim> claims_;
  std::vector<Naming> namings_;
  std::vector<hal::RobotId> duplicates_;
  hal::LabTime ended_at_{0};
};

}  // namespace arkmesh::tracker
