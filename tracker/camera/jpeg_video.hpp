// A video of single JPEG pictures as an AVI, by FFmpeg's library. OpenCV's own writer of such files leaves out the last
// bits of some pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

namespace arkmesh::tracker {

class JpegVideo {
 public:
  // Throws std::runtime_error with one sentence, as `write` does.
  JpegVideo(const std::string& file, cv::Size size, double pictures_per_s);
  ~JpegVideo();  // completes the file
  void write(const cv::Mat& bgr);

 private:
  struct File;
  std::string name_;
  std::unique_ptr<File> file_;
  std::int64_t pictures_ = 0;
};

}  // namespace arkmesh::tracker
