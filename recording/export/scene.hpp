// What an arena shows, as messages of Foxglove's schemas, which Foxglove and Rerun draw: robots as points in the colour
// of their LED, their poses, walls and obstacles, robots of other labs likewise, and what the scenario draws. Positions
// are in the lab's arena frame, which is the frame of the lab's name; metres.
#pragma once

#include <google/protobuf/message.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/layout/message.hpp"

namespace foxglove {
class SceneEntity;
}

namespace arkmesh::recording {

class Scene {
 public:
  struct Shown {
    const char* topic;  // "robots", "others", "headings", "scene" or "frames"
    std::unique_ptr<google::protobuf::Message> message;
  };
  // Arenas lie beside each other in the frame "world"; `next_x_m` is where the next one begins, and outlives this.
  Scene(std::string lab, double& next_x_m) : lab_(std::move(lab)), next_x_m_(next_x_m) {}
  // For a message of this channel that check() has passed; empty: nothing new is drawn. Poses are shown twice a second
  // of lab time at most, robots in each frame: places to 8 um, headings to 0.01 degrees. `time_ns` since 1970.
  std::vector<Shown> update(std::string_view channel, std::int64_t t_us, std::uint64_t time_ns,
                            const hal::layout::Type& type, std::span<const std::byte> message);

 private:
  void show_robots(std::vector<Shown>& out, std::int64_t t_us, std::uint64_t time_ns, const hal::layout::Type& type,
                   std::span<const std::byte> message);
  // Of the scenario, or of the arena. False: the message is not understood.
  bool draw(foxglove::SceneEntity& to, std::string_view channel, const hal::layout::Type& type,
            std::span<const std::byte> message);

  std::string lab_;
  double& next_x_m_;
  bool placed_ = false;
  double body_height_m_ = 0;    // of its robots, once the arena was told
  std::int64_t poses_us_ = -1;  // when poses were shown last
};

}  // namespace arkmesh::recording
