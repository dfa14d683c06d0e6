#include "tests/support/emulated/tracking_referee.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace arkmesh::tests {
namespace {

using Truth = emulator::Emulator::Truth;

constexpr double body_m = 0.0165;  // a track nearer than this lies on the robot
constexpr hal::LabTime settling{1'000'000}, rename_after{2'000'000};
constexpr std::size_t max_lapses = 400;

double apart_m(const hal::Pose& a, const hal::Pose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

struct Nearest {
  std::size_t robot = 0;
  double off_m = std::numeric_limits<double>::infinity();
};

Nearest nearest_to(const hal::Pose& pose, std::span<const Truth> truth) {
  Nearest best;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth[i].seen.in_arena) continue;
    if (const double off_m = apart_m(truth[i].seen.pose, pose); off_m < best.off_m) best = {i, off_m};
  }
  return best;
}

}  // namespace

double TrackingScore::centre_rms_mm() const {
  return 1000 * std::sqrt(square_m / static_cast<double>(seen));
}
double TrackingScore::heading_rms_deg() const {
  return std::sqrt(square_rad / static_cast<double>(headings)) * 180 / std::numbers::pi;
}
double TrackingScore::stated_square() const {
  double sum = 0;
  for (const auto& [robot, each] : squares) sum += each[0] / each[1];
  return sum / static_cast<double>(squares.size());
}
double TrackingScore::led_right_percent() const {
  std::uint64_t right = 0, all = 0;
  for (std::size_t is = 0; is < led.size(); ++is)
    for (std::size_t seems = 0; seems < led.size(); ++seems)
      all += led[is][seems], right += is == seems ? led[is][seems] : 0;
  return 100.0 * static_cast<double>(right) / static_cast<double>(all);
}

void TrackingReferee::note(hal::LabTime now, std::string what) {
  if (lapses_.size() < max_lapses)
    lapses_.push_back(fmt::format("{:8.3f} s  {}", static_cast<double>(now.count()) * 1e-6, what));
}

void TrackingReferee::judge(hal::LabTime now, std::span<const Truth> truth, tracker::ArenaTracker& tracking) {
  const std::vector<tracker::Track> tracks = tracking.tracks();
  if (!begun_) {
    begun_ = now;
    lost_.assign(truth.size(), false);
  }
  if (now - *begun_ < settling) {
    for (const tracker::Track& track : tracks)
      if (const Nearest at = nearest_to(track.in_arena, truth); at.off_m < body_m && (!track.robot || track.doubtful)) {
        tracking.associator().name(track.number, static_cast<hal::RobotId>(at.robot));
        ++score_.namings;
      }
    return;
  }

  std::vector<int> tracked(truth.size()), on_it(truth.size());
  std::map<tracker::TrackNumber, hal::LabTime> nameless_since, strange_since;
  std::map<tracker::TrackNumber, hal::RobotId> wrong;
  for (const tracker::Track& track : tracks) {
    const Nearest at = nearest_to(track.in_arena, truth);
    const bool seen = track.age.count() == 0, on_robot = at.off_m < body_m;
    const auto describe = [&] {
      return fmt::format("track {} at {:.4f},{:.4f}, age {} ms, confidence {:.2f}", track.number, track.in_arena.x_m,
                         track.in_arena.y_m, track.age.count() / 1000, track.confidence);
    };
    if (seen && !on_robot) {
      ++score_.strangers;
      strange_since[track.number] = now;
      if (!strange_since_.contains(track.number))
        note(now, fmt::format("stranger: {}, {:.1f} mm from robot {}", describe(), 1000 * at.off_m, at.robot));
    }
    if (seen && on_robot && ++on_it[at.robot] == 2)
      ++score_.twice, note(now, fmt::format("twice: {} on robot {}", describe(), at.robot));
    if (track.robot) {
      const Truth& named = truth[*track.robot];
      if (!named.seen.in_arena || apart_m(named.seen.pose, track.in_arena) > body_m) {
        ++(track.doubtful ? score_.wrong_doubted : score_.wrong);
        wrong[track.number] = *track.robot;
        if (!wrong_.contains(track.number) && (!track.doubtful || on_robot))
          note(now, fmt::format("{}: {} is on {} but named {}", track.doubtful ? "wrong, doubted" : "WRONG", describe(),
                                at.robot, *track.robot));
      } else if (++tracked[*track.robot] == 1) {
        ++score_.tracked;
        if (!track.doubtful) ++score_.sure;
        if (seen) {
          const hal::Pose& pose = named.seen.pose;
          const double off_x_m = track.in_arena.x_m - pose.x_m, off_y_m = track.in_arena.y_m - pose.y_m;
          ++score_.seen;
          score_.square_m += off_x_m * off_x_m + off_y_m * off_y_m;
          score_.max_m = std::max(score_.max_m, std::hypot(off_x_m, off_y_m));
          score_.sum_x_m += off_x_m;
          score_.sum_y_m += off_y_m;
          if (track.led_seen) ++score_.led[static_cast<std::size_t>(named.led)][static_cast<std::size_t>(track.led)];
          if (track.led_seen && track.led != hal::Led::off && named.led != hal::Led::off) {
            const double off_rad = tracker::wrapped(track.in_arena.heading_rad - pose.heading_rad);
            score_.square_rad += off_rad * off_rad;
            ++score_.headings;
            auto& [square, number] = score_.squares[*track.robot];
            square += off_rad * off_rad / (track.heading_sigma_rad * track.heading_sigma_rad);
            ++number;
          }
          if (named.led == hal::Led::off && track.led == hal::Led::off && track.heading_sigma_rad < 1.05f) {
            const double off_rad = tracker::wrapped(track.in_arena.heading_rad - pose.heading_rad);
            TrackingScore::Dark& dark = score_.dark[tracking.associator().touches(track.number) ? 1 : 0];
            ++dark.headings;
            dark.square_rad += off_rad * off_rad;
            dark.stated_square += off_rad * off_rad / (track.heading_sigma_rad * track.heading_sigma_rad);
          }
        }
      }
    }
    if ((track.robot && !track.doubtful) || !seen || !on_robot) continue;
    const hal::LabTime since = nameless_since_.contains(track.number) ? nameless_since_[track.number] : now;
    nameless_since[track.number] = since;
    if (now - since < rename_after) continue;
    tracking.associator().name(track.number, static_cast<hal::RobotId>(at.robot));
    nameless_since.erase(track.number);
    ++score_.namings;
  }
  nameless_since_ = std::move(nameless_since);
  strange_since_ = std::move(strange_since);
  wrong_ = std::move(wrong);

  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth[i].seen.in_arena) continue;
    ++score_.robot_frames;
    const bool lost = !tracked[i];
    if (lost && !lost_[i]) {
      double neighbour_m = 1;
      for (std::size_t j = 0; j < truth.size(); ++j)
        if (j != i && truth[j].seen.in_arena)
          neighbour_m = std::min(neighbour_m, apart_m(truth[i].seen.pose, truth[j].seen.pose));
      note(now, fmt::format("lost: robot {} at {:.4f},{:.4f}, nearest neighbour {:.1f} mm", i, truth[i].seen.pose.x_m,
                            truth[i].seen.pose.y_m, 1000 * neighbour_m));
    } else if (!lost && lost_[i]) {
      note(now, fmt::format("found again: robot {}", i));
    }
    lost_[i] = lost;
  }
}

}  // namespace arkmesh::tests
