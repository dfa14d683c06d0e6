// Eyes that see robots in a row, unless a test covers the camera or takes robots away.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/platforms/aseba/aseba_arena.hpp"

namespace arkmesh::tests {

// What the eyes see, in the test's hand.
struct ScriptedSight {
  std::vector<hal::RobotId> robots, missing;
  bool covered = false;
  int looks = 0, looks_for_picture = 1;  // every so many looks there is a new one
  double x_m = 0;                        // of all robots
};

class ScriptedEyes final : public hal::aseba::Eyes {
 public:
  explicit ScriptedEyes(std::shared_ptr<ScriptedSight> sight) : sight_(std::move(sight)) {}
  void look(hal::LabTime) override {
    if (sight_->covered || ++sight_->looks % sight_->looks_for_picture != 0) return;
    frame_.emplace();
    for (const hal::RobotId robot : sight_->robots)
      if (std::ranges::count(sight_->missing, robot) == 0)
        frame_->robots.push_back({robot, {sight_->x_m, 0.1, 0}, hal::Led::unknown, 1, {}, 0.02F});
  }
  std::optional<hal::PoseFrame> latest() override { return std::exchange(frame_, std::nullopt); }
  const std::vector<hal::RobotId>& missing() const override {
    return sight_->covered ? sight_->robots : sight_->missing;
  }
  std::string error() const override { return sight_->covered ? "the camera is covered" : ""; }
  const hal::Counters& counters() const override { return counters_; }

 private:
  std::shared_ptr<ScriptedSight> sight_;
  std::optional<hal::PoseFrame> frame_;
  hal::Counters counters_;
};

}  // namespace arkmesh::tests
