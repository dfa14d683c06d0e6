// Whether a camera still hangs where it was calibrated: believes no place in its pictures before they show the
// landmarks of the calibration, corrects a calibration that the landmarks contradict, and says so.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "hal/counters.hpp"
#include "tracker/camera/camera_guard.hpp"
#include "tracker/follow/arena_tracker.hpp"

namespace arkmesh::testbed {

// One camera of the tracker that each call is given. Counts camera.moved and camera.unrecognised (times that a picture
// did not show the testbed as it should), camera.refused.moved and .unrecognised (pictures not used for that),
// camera.realigned (times a calibration followed a camera), camera.moved_at_start (it was moved since it was
// calibrated, and nobody knows how); camera.no_landmarks (of the calibration) and camera.unrecognised_at_start (they
// are not what the camera sees): in both cases nobody knows whether it was moved before its first picture with robots.
class PlacedCamera {
 public:
  // `source`: as people call the camera; `remedy`: the command that calibrates it. Few landmarks are as none.
  PlacedCamera(std::size_t number, std::string source, std::string remedy, std::span<const tracker::Landmark> landmarks,
               const tracker::ArenaTracker& tracker, hal::Counters& counters);

  // Whether places in that picture can be believed. May correct the tracker's calibration.
  bool in_place(const cv::Mat& picture, tracker::ArenaTracker& tracker, hal::Counters& counters);
  // After the tracker has looked at a picture that can be believed: takes its landmarks where the calibration's are
  // none.
  void learn(const cv::Mat& picture, const tracker::ArenaTracker& tracker, hal::Counters& counters);
  // One sentence while the camera cannot be used until somebody calibrates it again; else empty.
  const std::string& error() const { return error_; }

 private:
  bool at_start(tracker::CameraGuard::Verdict verdict, hal::Counters& counters);

  std::size_t number_;
  std::string source_, remedy_, error_;
  tracker::CameraGuard guard_;
  bool settled_ = true;                      // else the calibration's landmarks have not been seen yet
  bool renew_ = false;                       // few of them: the first picture with robots shows better ones
  int unrecognised_ = 0, robots_ = 0;        // pictures in a row before that: without landmarks; in them, with robots
  int moved_ = 0;                            // pictures since the first that was from elsewhere
  bool amiss_ = false, said_moved_ = false;  // as last said
};

}  // namespace arkmesh::testbed
