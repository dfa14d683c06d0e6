// Judges how well a testbed is tracked, frame by frame, against the truth of an emulated testbed. Names tracks from the
// truth, as an identifier would: at once in the first second, which is not judged; later ones and doubtful ones after
// two seconds in which they stayed so.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"
#include "hal/types.hpp"
#include "tracker/follow/arena_tracker.hpp"

namespace arkmesh::tests {

// What was true and what is judged: robots and tracks, frame by frame.
struct TrackingScore {
  std::uint64_t robot_frames = 0;   // of robots in the arena
  std::uint64_t tracked = 0;        // a track of the robot's own name is on it
  std::uint64_t sure = 0;           // ... and free of doubt: messages go to it
  std::uint64_t seen = 0;           // ... and was seen in this very frame
  std::uint64_t wrong = 0;          // a name free of doubt is that of another robot
  std::uint64_t wrong_doubted = 0;  // a doubtful name is
  std::uint64_t strangers = 0;      // a track seen in this frame where no robot is
  std::uint64_t twice = 0;          // a second track on one robot, both seen in this frame
  std::uint64_t namings = 0;
  std::uint64_t headings = 0;                                // of robots seen with their LED on
  double square_m = 0, sum_x_m = 0, sum_y_m = 0, max_m = 0;  // of the centres of those seen
  double square_rad = 0;
  std::map<hal::RobotId, std::array<double, 2>> squares;  // of headings in units of what was stated, and their number
  // Of robots seen with their LED off and a heading stated to within 60 degrees: [touching nothing, touching].
  struct Dark {
    std::uint64_t headings = 0;
    double square_rad = 0, stated_square = 0;
  };
  std::array<Dark, 2> dark;
  std::array<std::array<std::uint64_t, 8>, 8> led{};  // [true][seen], of LEDs that were seen

  double tracked_percent() const { return 100.0 * static_cast<double>(tracked) / static_cast<double>(robot_frames); }
  double centre_rms_mm() const;
  double heading_rms_deg() const;
  double stated_square() const;  // mean of (error / stated deviation)^2 of headings, each robot counted once
  double led_right_percent() const;
};

class TrackingReferee {
 public:
  // Call after each look; `truth` is that of the moment of the pictures. Names tracks.
  void judge(hal::LabTime now, std::span<const emulator::Emulator::Truth> truth, tracker::ArenaTracker& tracking);

  const TrackingScore& score() const { return score_; }
  // What went wrong, a line each, the first few hundred: robots that were lost, names that were wrong, strangers.
  const std::vector<std::string>& lapses() const { return lapses_; }

 private:
  void note(hal::LabTime now, std::string what);

  TrackingScore score_;
  std::optional<hal::LabTime> begun_;
  std::map<tracker::TrackNumber, hal::LabTime> nameless_since_, strange_since_;
  std::vector<bool> lost_;
  std::map<tracker::TrackNumber, hal::RobotId> wrong_;
  std::vector<std::string> lapses_;
};

}  // namespace arkmesh::tests
