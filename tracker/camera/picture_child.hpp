// A process of its own that reads a video or a stream: should FFmpeg crash or hang there, that costs the child only.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "hal/child_process.hpp"
#include "tracker/camera/picture_reader.hpp"

namespace arkmesh::tracker {

class PictureChild {
 public:
  // The child ends with this object, and with the thread that made it. Throws std::runtime_error with one sentence.
  explicit PictureChild(PictureSource source);

  struct Event {
    PictureRecord record;
    cv::Mat bgr;                     // of jpeg and bgr, upright; empty: a JPEG that cannot be decoded
    std::vector<std::uint8_t> jpeg;  // as it came
    std::string error;               // of failed: one sentence
  };
  // Waits. A child that died, or gave nothing for long, is `failed`; so is all that is asked after it, and after
  // `ended`. `stop` is asked several times a second; once it is true, `failed` without a sentence.
  Event next(const std::function<bool()>& stop);
  // For tests.
  const hal::ChildProcess& process() const { return child_; }

 private:
  bool read(void* to, std::size_t bytes, const std::function<bool()>& stop);
  Event failed(std::string error) const;

  PictureSource source_;
  hal::ChildProcess child_;
  bool silent_ = false;  // it gave nothing for long
};

}  // namespace arkmesh::tracker
