// A window on a testbed of real Kilobots: camera pictures with what the lab knows drawn over them, live for any browser
// on this machine and, on request, as videos beside the other results.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hal/arena_row.hpp"
#include "hal/bus.hpp"
#include "hal/counters.hpp"
#include "hal/drawing.hpp"
#include "hal/event_loop.hpp"
#include "hal/mjpeg_server.hpp"
#include "hal/on_loop.hpp"
#include "testbed/arena_monitor.hpp"

namespace arkmesh::testbed {

class ArenaView {
 public:
  // Live pictures are at http://127.0.0.1:PORT/, which the log says; videos come into `directory`. Virtual things to
  // draw come over `bus`; it and `loop` outlive the window. Throws std::runtime_error when the port is taken.
  ArenaView(const KilobotSettings& settings, hal::Bus& bus, hal::EventLoop& loop, std::filesystem::path directory);

  // Draws, shows and stores what was just seen. Costs nothing while nobody watches and no video is made. What is shown
  // last is shown again each second, with what the bus has told since, while nothing new is seen.
  void look(const testbed::Look& look);

 private:
  struct Video {
    cv::VideoWriter writer;
    bool failed = false;
  };

  void hear_shared(std::span<const std::byte> bytes);
  bool watched(std::size_t camera) const { return server_ && server_->watchers(stream(camera)) > 0; }
  cv::Mat draw(const cv::Mat& picture, std::size_t camera, const tracker::TableTracker& tracker) const;
  void show(std::size_t camera, cv::Mat drawn, const std::string& words);
  void show_again();
  void store(std::size_t camera, const cv::Mat& drawn);
  static std::string stream(std::size_t camera) { return "camera" + std::to_string(camera); }

  std::string lab_;
  hal::LabTime frame_period_;
  std::filesystem::path directory_;
  std::unique_ptr<hal::MjpegServer> server_;  // none: nobody may watch
  bool keep_video_;
  std::map<std::size_t, Video> videos_;
  struct Last {
    cv::Mat picture;
    hal::LabTime at{0}, missing{0};  // when it came; how long none has come since
    std::chrono::steady_clock::time_point shown{};
  };
  std::map<std::size_t, Last> last_;                // of each camera
  const tracker::TableTracker* tracker_ = nullptr;  // of who calls look() and owns this
  hal::Drawing overlay_;                            // the scenario's
  std::vector<hal::Observation> ghosts_;            // robots of other labs, where they are in this arena
  hal::Counters refused_;                           // of what came for overlay_
  std::vector<std::unique_ptr<hal::Bus::Subscription>> subscriptions_;
  std::optional<hal::Repeating> again_;
};

// Nothing when nobody watches the arena that is asked for. Refuses `kilobot`'s port when it is taken.
Observer make_window(const hal::Section& kilobot, const KilobotSettings& settings, const hal::ArenaRequest& request);

}  // namespace arkmesh::testbed
