// Writes a record's lines and pictures to disk on a thread of its own, so that no disk and no compression makes a lab
// wait. Bounded in memory and on disk: what has no room is left out and counted, and nothing ends because of it.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::testbed {

class RecordWriter {
 public:
  struct Settings {
    std::filesystem::path folder;
    bool patient = false;                          // who brings pictures faster than they are written waits
    std::uint64_t keep_free_bytes = 512ull << 20;  // pictures end when the disk has less left
    std::size_t hold_bytes = 256u << 20;           // memory for what waits to be written
  };
  // Writes nothing yet: lines wait for begin().
  explicit RecordWriter(Settings settings) : settings_(std::move(settings)) {}
  ~RecordWriter() { finish(); }
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;

  // Makes the folder. Throws std::runtime_error with one sentence when nothing can be written there.
  void begin();
  // Returns when everything is written, if it has begun. Nothing may follow.
  void finish();
  // A line for that file of the folder, without its end. It reaches the system within milliseconds, ahead of pictures
  // that wait.
  void line(const std::string& file, const std::string& text);
  // A picture for that file of the folder: `jpeg`, or where that is empty `bgr` as PNG, which loses nothing. False: it
  // is not kept.
  bool picture(const std::filesystem::path& file, const cv::Mat& bgr, std::vector<std::uint8_t> jpeg);

  struct Written {
    std::uint64_t pictures = 0, bytes = 0;
  };
  Written written() const;
  // Why something is not recorded any more, one sentence; empty while all is.
  std::string error() const;
  // raw.not_recorded.disk_full and .too_fast (pictures), .lines, .picture_failed.
  hal::Counters counters() const;

 private:
  struct Line {
    std::string file, text;
  };
  struct Picture {
    std::filesystem::path file;
    cv::Mat bgr;  // only read: the lab looks at it meanwhile
    std::vector<std::uint8_t> jpeg;
    std::size_t bytes() const { return jpeg.empty() ? bgr.total() * bgr.elemSize() : jpeg.size(); }
  };
  void run();
  void write(const std::deque<Line>& lines);
  void write(const Picture& picture);
  void fail(const char* counter, const std::string& why, std::uint64_t times = 1);

  const Settings settings_;
  mutable std::mutex mutex_;  // guards all below but the last two
  std::condition_variable work_, room_;
  std::deque<Line> lines_;
  std::deque<Picture> pictures_;
  std::size_t held_bytes_ = 0;
  bool stopping_ = false, disk_full_ = false, lines_failed_ = false;
  Written written_;
  std::string error_;
  hal::Counters counters_;
  std::vector<std::pair<std::string, std::ofstream>> files_;  // the thread's
  std::thread thread_;
};

}  // namespace arkmesh::testbed
