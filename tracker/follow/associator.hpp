// Follows robots from frame to frame: gives all observations of a frame to all tracks at once, so that the whole fits
// best. Says of a track when it may be somebody else; finding out who it is, is the identifier's work. Pure: no
// pictures, no clock.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "hal/counters.hpp"
#include "tracker/follow/assignment.hpp"
#include "tracker/follow/fused_observation.hpp"
#include "tracker/follow/motion.hpp"
#include "tracker/follow/track.hpp"

namespace arkmesh::tracker {

// Of a robot whose LED was measured: driving direction minus LED direction, and the standard error of that.
struct LedOffset {
  double rad = 0, error_rad = 0;
};

struct AssociatorSettings {
  double diameter_m = not_given;                   // of a robot's body; two bodies cannot overlap
  double half_width_m = 1e9, half_height_m = 1e9;  // the walls' distance from the arena's middle, along x and y
  double led_offset_rad = not_given;               // driving direction minus LED direction, and
  double led_offset_error_rad = 0;                 // by how much it differs between robots: standard deviation
  // Of single robots in its place, as soon as they are named. Of three or more the mean stands for all other robots,
  // with their standard deviation.
  std::map<hal::RobotId, LedOffset> led_offsets;
  double top_speed_m_s = 0.06;  // nobody walks faster, pushed or played at four times life speed
  double reach_m = 0.016;       // how far a hand moves a robot between two frames without it counting as another one
  hal::LabTime doubt_after{200'000};  // unseen for this long: nobody acts on the id until it is seen again
  hal::LabTime swap_after{
      800'000};  // unseen for this long: it may be another one when it is seen again, and must be named anew
  hal::LabTime show_for{1'000'000};      // unseen for this long: no longer reported
  hal::LabTime forget_after{5'000'000};  // unseen for this long: gone; what appears there later is a new track
  double min_certainty = 5;  // natural logarithm of how much likelier an assignment must be than its neighbours
  MotionSettings motion;
};

// Where a track should be seen next, and how far from there it may be.
struct Prospect {
  TrackNumber number = 0;
  double x_m = 0, y_m = 0;
  double reach_m = 0;
};

// Counters: track.born, .ended (no longer shown), .doubtful (became so), .jumped (moved by hand), .renamed (bore
// another robot's name); seen.too_close (overlaps a robot); track.places, .headings: how often a place or LED was
// compared with what motion let expect, and .off_um2 or .off_mrad2, the sum of the squared differences, of one
// coordinate each, and .misfit, that of the same by the variance that was stated, in hundredths.
class Associator {
 public:
  explicit Associator(const AssociatorSettings& settings);

  // Every track that is in the picture or has been lately, lost ones too, ascending. `now` at or after that of the last
  // update.
  std::vector<Prospect> prospects(hal::LabTime now) const;
  // One frame. Returns what is to be reported, ascending by number. `now` never decreases.
  const std::vector<Track>& update(hal::LabTime now, std::span<const FusedObservation> seen);
  const std::vector<Track>& tracks() const { return reported_; }
  // Whether the robot touched another or a wall in the last frame, as far as places tell. False when there is no such
  // track any more.
  bool touches(TrackNumber track) const;

  // The track is that robot and no doubt is left; any other track of that name loses it. False when there is no such
  // track any more.
  bool name(TrackNumber track, hal::RobotId robot);
  // The track is not who it was thought to be.
  void unname(TrackNumber track);
  const hal::Counters& counters() const { return counters_; }
  const Misfits& places() const { return places_; }
  const Misfits& headings() const { return headings_; }
  double led_noise() const { return led_noise_; }

 private:
  struct Followed {
    Track track;
    Motion motion;
    hal::LabTime last_seen{0};
    hal::LabTime led_told{0};  // when the camera could last tell its colour
    std::uint32_t times_seen = 1;
    bool established = false;  // seen often or clearly enough to be reported
    bool suspected = false;    // doubtful until named again
    bool jumped =
        false;  // last seen where no motion explains it: a hand, or something else; the next observation tells
    bool shown = true;
    bool touching = false;  // another or a wall
    struct Look {
      hal::LabTime at{-1'000'000};
      double led_rad = 0;
    };
    std::array<Look, 2> looks;  // the last ones at its LED, the newest first
  };

  void find_touching();
  double reach_m(const Followed& followed, hal::LabTime now) const;
  std::vector<Pairing> possible_pairs(hal::LabTime now, std::span<const FusedObservation> seen) const;
  // How far off it may be seen, along an axis.
  static double off_variance_m2(const Followed& followed, const FusedObservation& seen, hal::LabTime now);
  double gain(const Followed& followed, const FusedObservation& seen, hal::LabTime now) const;
  void suspect_ambiguous(std::span<const Pairing> possible, std::span<const std::int32_t> seen_by);
  void doubt(Followed& followed);
  void meet(Followed& followed, const FusedObservation& seen, hal::LabTime now);
  void learn_led_noise(Followed& followed, const FusedObservation& seen, hal::LabTime now);
  void miss(Followed& followed, hal::LabTime now);
  void give_birth(std::span<const FusedObservation> seen, std::span<const std::int32_t> seen_by, hal::LabTime now);
  void report(hal::LabTime now);
  LedOffset led_offset(const Followed& followed) const;
  Followed* find(TrackNumber number);

  AssociatorSettings settings_;
  LedOffset usual_led_offset_;      // of robots that have none of their own
  std::vector<Followed> followed_;  // ascending by number
  std::vector<Track> reported_;
  TrackNumber next_ = 0;
  hal::LabTime now_{0};
  Misfits places_, headings_;
  double led_noise_ = 1;  // of LEDs' directions, in parts of the deviation that was stated; learnt
  hal::Counters counters_;
};

}  // namespace arkmesh::tracker
