// From pictures to robots that carry markers: who is who is written on them. A picture is searched around the places
// where markers should be; a part of it, another each time, is searched while one is missing. No clock, no threads.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/counters.hpp"
#include "hal/types.hpp"
#include "tracker/camera/calibration.hpp"
#include "tracker/detect/marker_finder.hpp"

namespace arkmesh::tracker {

struct MarkerSettings {
  std::string family = "apriltag_36h11";
  double side_m = 0.05;              // of the black square
  double height_m = 0;               // of the marker above the arena
  double turned_rad = 0;             // driving direction minus the direction of the printed top
  double top_speed_m_s = 0.2;        // of robots
  std::vector<hal::RobotId> robots;  // whose ids are the numbers of their markers, ascending
};

// Counters: marker.refused.size (a marker's sides are not those of `side_m` at that place: a reflection, a picture of a
// marker), marker.refused.unknown and .twice (looks that found a number that is nobody's, or that one camera saw
// twice), camera.refused.size.
class MarkerTracker {
 public:
  MarkerTracker(std::vector<Calibration> cameras, MarkerSettings settings);

  // pictures[i] is what camera i sees now; an empty one: nothing new. `now` never decreases. Robots that were seen now,
  // ascending; their LED is not known.
  std::vector<hal::Observation> look(hal::LabTime now, std::span<const cv::Mat> pictures);
  // Robots that the last look with a picture did not find, ascending.
  const std::vector<hal::RobotId>& missing() const { return missing_; }
  const hal::Counters& counters() const { return counters_; }
  std::size_t cameras() const { return views_.size(); }
  const Calibration& calibration(std::size_t camera) const { return views_[camera].calibration; }

  // How fast a marker may move so that its squares are not blurred into each other while a picture is exposed.
  static double largest_speed_m_s(const MarkerSettings& settings, double exposure_s);

 private:
  struct Seen {
    hal::LabTime at{0};
    hal::Pose pose;
    double vx_m_s = 0, vy_m_s = 0;
  };
  struct View {
    Calibration calibration;
    int next_part = 0;
  };
  std::vector<Marker> find(View& view, const cv::Mat& picture, hal::LabTime now, bool anybody_missing);
  std::optional<cv::Rect> window(const View& view, const Seen& seen, hal::LabTime now) const;
  std::optional<hal::Pose> pose_of(const View& view, const Marker& marker) const;

  MarkerSettings settings_;
  MarkerFinder finder_;
  std::vector<View> views_;
  std::map<hal::RobotId, Seen> seen_;
  std::vector<hal::RobotId> missing_;
  hal::Counters counters_;
};

}  // namespace arkmesh::tracker
