// From pictures to tracks: detects in each camera's picture, brings the cameras together, follows. No threads, no
// clock, no ids.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "hal/counters.hpp"
#include "tracker/camera/calibration.hpp"
#include "tracker/camera/rectified_view.hpp"
#include "tracker/detect/detector.hpp"
#include "tracker/follow/associator.hpp"
#include "tracker/follow/track.hpp"
#include "tracker/follow/view_fusion.hpp"

namespace arkmesh::tracker {

struct ArenaTrackerSettings {
  Body body;
  AssociatorSettings following;
  DetectorSettings detection;       // the diameter and its tolerance follow from the calibrations where there are any
  int search_every = 10;            // a whole picture is searched at least this often, else only where robots should be
  std::size_t expected_robots = 0;  // while fewer are seen, whole pictures are searched more often; 0: nobody knows
};

// Counters: those of Associator, camera.refused.size (pictures of another size than the calibration's), seen.outside
// (what looked like a robot and lies outside the arena).
class ArenaTracker {
 public:
  ArenaTracker(std::vector<Calibration> cameras, const ArenaTrackerSettings& settings);
  // One camera of which nothing is known: places are measured in robots' bodies, from the middle of the picture, as
  // seen from above.
  explicit ArenaTracker(const ArenaTrackerSettings& settings);

  // pictures[i] is what camera i sees now; an empty one: nothing new. At least one is not empty. `now` never decreases.
  // Returns the tracks to be reported, ascending by number.
  const std::vector<Track>& look(hal::LabTime now, std::span<const cv::Mat> pictures);

  Associator& associator() { return associator_; }
  const std::vector<Track>& tracks() const { return associator_.tracks(); }
  std::size_t cameras() const { return views_.size(); }
  // Nothing while the size of robots in the picture is not known yet.
  const Calibration* calibration(std::size_t camera) const {
    return views_[camera].calibration ? &*views_[camera].calibration : nullptr;
  }
  // The camera hangs like this from now on.
  void realign(std::size_t camera, Calibration calibration);
  // What the last look found in that camera's picture.
  const std::vector<Detection>& detections(std::size_t camera) const { return views_[camera].detections; }
  const hal::Counters& counters() const;

 private:
  struct View {
    std::optional<Calibration> calibration;
    std::optional<RectifiedView> plane;  // of a camera that looks aslant: there robots are looked for
    std::unique_ptr<Detector> detector;
    int since_search = 1'000'000;
    std::vector<Detection> detections;
  };

  std::vector<FusedObservation> inside_arena(const Calibration& camera, std::span<const Detection> detections);
  void detect(View& view, const cv::Mat& as_taken, std::span<const Prospect> prospects, bool somebody_missing);

  ArenaTrackerSettings settings_;
  std::vector<View> views_;
  Associator associator_;
  hal::Counters own_counters_;
  mutable hal::Counters counters_;
};

}  // namespace arkmesh::tracker
