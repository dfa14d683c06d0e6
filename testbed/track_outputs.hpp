// What `arkmesh track` makes of tracks: rows, lines of JSON, poses on a bus, drawn pictures for browsers, in a video,
// in a file.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hal/bus/bus.hpp"
#include "hal/http/mjpeg_server.hpp"
#include "hal/time/loop_time.hpp"
#include "testbed/track_stream.hpp"
#include "tracker/camera/source.hpp"
#include "tracker/follow/arena_tracker.hpp"

namespace arkmesh::testbed {

class TrackOutputs {
 public:
  // Opens what can be opened beforehand. `options` and `stop` outlive this. A video gets `pictures_per_s`, whatever the
  // source's own rate is. Throws std::runtime_error with one sentence that names the file, port or bus; so do all
  // below.
  TrackOutputs(const StreamOptions& options, double pictures_per_s, hal::StopRequest& stop);

  void add(const tracker::Picture& picture, const tracker::ArenaTracker& tracker);
  // Lets people who watch have their pictures; returns at `then`, or soon when there is nobody to serve or the operator
  // stops.
  void serve_until(std::chrono::steady_clock::time_point then);
  bool serving() const { return server_.has_value(); }
  std::size_t pictures() const { return pictures_; }
  std::size_t robots() const { return robots_; }  // in the last picture
  // Completes the files and prints a summary.
  void finish(const tracker::ArenaTracker& tracker);

 private:
  void write_rows(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks,
                  const tracker::Calibration* camera);
  void publish(const tracker::Picture& picture, const std::vector<tracker::Track>& tracks);
  void write_video(const cv::Mat& drawn, hal::LabTime stamp);
  void show(const cv::Mat& drawn, hal::LabTime stamp);

  const StreamOptions& options_;
  double pictures_per_s_;
  hal::StopRequest& stop_;
  std::ofstream csv_;
  std::optional<hal::Bus> bus_;
  hal::EventLoop loop_;
  hal::LoopTime time_{loop_};
  std::optional<hal::MjpegServer> server_;
  cv::VideoWriter video_;
  std::int64_t in_video_ = 0;  // pictures by the video's clock
  std::int64_t video_pictures_ = 0;
  cv::Mat last_picture_;
  std::size_t pictures_ = 0, most_ = 0, robots_ = 0;
};

}  // namespace arkmesh::testbed
