// Whether robots stand, by what cameras see of them: nobody else knows. Robots that were told to stand count as
// standing when they were seen to for long enough since; one that is out of sight never does. Time is the caller's.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "hal/time/wall_time.hpp"
#include "hal/types.hpp"

namespace arkmesh::hal {

class StandJudge {
 public:
  // How long a robot is looked at, and how far it may seem to come meanwhile. Cameras measure to 1 mm, and no
  // robot is slower than 3 mm/s. Turning counts where the heading is known.
  static constexpr std::chrono::milliseconds looks_for{2'000};
  static constexpr double still_within_m = 0.005;

  // `fastest_m_s`: nobody moves faster by itself.
  StandJudge(std::vector<RobotId> robots, double fastest_m_s) : robots_(std::move(robots)), fastest_m_s_(fastest_m_s) {}

  // Robots were told to stand, or to run: what was seen before does not count.
  void begin();
  // A frame, in the arena frame, at `now`. Who is not in it, or was not seen since the last one, was not in sight.
  void look(const PoseFrame& frame, TimePoint now);
  // Ascending.
  std::vector<NotStanding> not_standing(TimePoint now) const;
  // Whether at least half of the robots that walked or turned around `told`, not long before begin(), have gone on
  // since. Of walkers this is known before it is known which robots they are.
  bool most_walk_on(TimePoint told) const;
  // Robots that came so fast to where they are that somebody must have carried them; each once, ascending.
  std::vector<RobotId> take_carried();
  // Robots that have neither left their place nor turned for rests_after, since begin() or since they came there; then
  // for twice as long, and so on. Each such time once.
  std::vector<RobotId> take_resting() { return std::exchange(resting_, {}); }
  static constexpr std::chrono::seconds rests_after{10};

 private:
  struct Place {
    TimePoint at;
    double x_m, y_m, heading_rad;
    bool heading_known;
  };
  struct Rest {
    Place at;
    std::chrono::seconds until = rests_after;
    bool came = false;
  };
  // Without a gap, oldest first; the newest that is older than the time for which it is looked at is kept.
  using Places = std::deque<Place>;

  static std::vector<std::size_t> ends_of_parts(const Places& places);
  static bool turns(const Places& places);
  std::optional<NotStanding::Why> judge(const Places& places, TimePoint now) const;

  const std::vector<RobotId> robots_;
  const double fastest_m_s_;
  std::map<RobotId, Places> seen_;
  std::map<RobotId, TimePoint> newest_;  // when it was seen last, also before begin()
  std::map<RobotId, Rest> rests_;        // since begin()
  std::map<RobotId, TimePoint> walked_;  // when it had left its place or turned last, also before begin()
  std::vector<RobotId> carried_, resting_;
};

}  // namespace arkmesh::hal
