// What an emulator leaves behind: the truth about its robots as a table, and what its cameras saw as videos.
#pragma once

#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "emulator/emulator.hpp"

namespace arkmesh::emulator {

class EmulatorRecord {
 public:
  // Empty paths: neither. With several cameras each video's name gets the camera's: out.mp4 becomes out-NAME.mp4.
  // `.avi` keeps pictures as single JPEGs, `.mp4` is smaller. Throws std::runtime_error with one sentence.
  EmulatorRecord(const Emulator& emulator, const std::string& truth, const std::string& video);
  ~EmulatorRecord();

  bool wants_pictures() const { return !videos_.empty(); }
  // A row for each robot, now. Throws std::runtime_error when the disk is full.
  void add_truth(const Emulator& emulator);
  // `picture` is what camera `number` saw; nothing when it is gone: the last one is repeated, so that a video keeps
  // time.
  void add_picture(std::size_t number, const cv::Mat& picture);
  // Both, of everything as it is now.
  void add(Emulator& emulator);

 private:
  std::string truth_name_;
  std::ofstream truth_;
  struct Video;
  std::vector<std::unique_ptr<Video>> videos_;
  std::vector<cv::Mat> last_;
};

// Calibration of all cameras as they hung at first, with landmarks of the empty arena. Throws std::runtime_error with
// one sentence.
void write_calibration(const Emulator& emulator, const std::string& file);
// `pictures` pictures of a chessboard for each camera: FOLDER/NAME-NN.png, with 9 x 6 inner corners 25 mm apart.
void write_chessboards(const Emulator& emulator, int pictures, const std::string& folder);

}  // namespace arkmesh::emulator
