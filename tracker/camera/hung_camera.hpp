// Tells a camera that hangs, and so repeats its picture, from one that sees nothing change: compressed video of robots
// that stand still is equal to the bit, too. Knows no robots. No clock, no threads.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "hal/types.hpp"

namespace arkmesh::tracker {

class HungCamera {
 public:
  enum class Verdict : std::uint8_t {
    changed,  // the picture differs from the one before
    same,     // it is equal to the bit, as pictures of things that stand still may be
    hung,     // and the camera must be taken for one that hangs, until a picture differs
  };

  // One that is noisy differs from picture to picture wherever one looks, whatever robots do: no two of its pictures
  // are equal, unless a slow stream repeats each for a while. 30 pictures are 3 s of a lab's.
  static constexpr int noisy_pictures = 30;
  static constexpr hal::LabTime noisy_hangs_after{500'000};
  // One without noise, of what should change. A Kilobot goes ten of its own widths meanwhile.
  static constexpr hal::LabTime quiet_hangs_after{10'000'000};

  // `bgr`, 8 bit, has newly come from the camera; it is kept, not copied. `changes`: what the camera sees should change
  // now, because robots run or are to answer with their LEDs. `now` never decreases.
  Verdict look(hal::LabTime now, const cv::Mat& bgr, bool changes);

 private:
  cv::Mat last_;
  hal::LabTime changed_at_{0}, changes_since_{0};
  bool changes_ = false, hung_ = false;
  int noisy_ = 0;  // so many pictures in a row differed nearly everywhere from the one before
};

}  // namespace arkmesh::tracker
