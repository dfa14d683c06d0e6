// What the cameras of a testbed see, for pages: turned so that it is as seen from straight above, at the height of the
// robots' boards, without the lens's distortion. Then pictures and what is drawn over them lie on each other
// everywhere. Costs nothing while nobody watches, and a small share of the time while somebody does.
#pragma once

#include <chrono>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "hal/arenas/picture_board.hpp"
#include "testbed/arena_monitor.hpp"
#include "tracker/camera/calibration.hpp"

namespace arkmesh::testbed {

// The part of the arena's surroundings that one camera sees, from above.
class StraightView {
 public:
  // Nothing when the camera sees nothing of the arena. `largest_px`: of the picture's sides.
  static std::optional<StraightView> of(const tracker::Calibration& camera, double board_m, int largest_px);

  cv::Mat turn(const cv::Mat& picture) const;
  const hal::PictureFrame& frame() const { return frame_; }
  // Whether it was made for a camera that lies so.
  bool is_of(const tracker::Calibration& camera) const;

 private:
  StraightView() = default;

  hal::PictureFrame frame_;  // without the camera's name
  cv::Mat places_, parts_;   // where each pixel comes from, and its fraction
  std::array<double, 12> pose_{};
};

class StraightPictures {
 public:
  // The board outlives it.
  explicit StraightPictures(hal::PictureBoard& board) : board_(board) {}
  void look(const Look& look);

 private:
  using Monotonic = std::chrono::steady_clock;
  void show(hal::PictureWatcher& watcher, std::size_t camera, const cv::Mat& picture, const Look& look);

  hal::PictureBoard& board_;
  std::map<std::size_t, std::optional<StraightView>> views_;
  std::map<std::size_t, Monotonic::time_point> next_;  // of each camera
};

}  // namespace arkmesh::testbed
