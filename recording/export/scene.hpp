// What an arena shows, as messages of Foxglove's schema `foxglove.SceneUpdate` in JSON, so that its 3D panel draws it:
// walls, obstacles, robots with heading and LED, robots of other labs as rings, and what the scenario draws. Positions
// are in the lab's arena frame, which is the frame of the lab's name; metres.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/layout/message.hpp"

namespace arkmesh::recording {

class Scene {
 public:
  explicit Scene(std::string lab) : lab_(std::move(lab)) {}
  // A SceneUpdate for a message of this channel that check() has passed; empty: nothing new is drawn. Robots are drawn
  // 5 times a second of lab time at most. `time_ns` since 1970.
  std::string update(std::string_view channel, std::int64_t t_us, std::uint64_t time_ns, const hal::layout::Type& type,
                     std::span<const std::byte> message);

 private:
  std::string lab_;
  std::int64_t robots_us_ = -1;     // when robots were drawn last
  double robot_radius_m_ = 0.0165;  // of a Kilobot, until the arena tells another; recordings of before do not
};

// The JSON schema of foxglove.SceneUpdate.
std::string scene_schema();

}  // namespace arkmesh::recording
