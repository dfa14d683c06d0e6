// What people see of a testbed of Kilobots: its cameras' pictures for the lab's page and, on request, videos beside the
// other results, with what the lab knows drawn over them.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "hal/arenas/arena_row.hpp"
#include "hal/bus/bus.hpp"
#include "hal/counters.hpp"
#include "hal/overlay/drawing.hpp"
#include "testbed/arena_monitor.hpp"

namespace arkmesh::testbed {

class ArenaVideo {
 public:
  // Videos come into `directory`, one for each camera. Virtual things to draw come over `bus`, which outlives this.
  ArenaVideo(const KilobotSettings& settings, hal::Bus& bus, std::filesystem::path directory);

  // Draws and stores what was just seen.
  void look(const testbed::Look& look);

 private:
  struct Video {
    cv::VideoWriter writer;
    bool failed = false;
  };

  void hear_shared(std::span<const std::byte> bytes);
  cv::Mat draw(const cv::Mat& picture, std::size_t camera, const tracker::ArenaTracker& tracker) const;
  void store(std::size_t camera, const cv::Mat& drawn);

  std::string lab_;
  hal::LabTime frame_period_;
  std::filesystem::path directory_;
  std::map<std::size_t, Video> videos_;
  hal::Drawing overlay_;                  // the scenario's
  std::vector<hal::Observation> ghosts_;  // robots of other labs, where they are in this arena
  hal::Counters refused_;                 // of what came for overlay_
  std::vector<std::unique_ptr<hal::Bus::Subscription>> subscriptions_;
};

// Pictures and videos as they are asked for; nothing when nobody watches the arena.
Observer make_viewers(const KilobotSettings& settings, const hal::ArenaRequest& request);

}  // namespace arkmesh::testbed
