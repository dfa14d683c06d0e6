// Eyes that see what a test tells them to: robots in a row, unless the camera is covered.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/platforms/kilobot/robot_monitor.hpp"

namespace arkmesh::tests {

// What the eyes see, in the test's hand. Shared with the eyes, which may live in an arena.
struct FakeTestbed {
  std::vector<hal::RobotId> robots;
  std::vector<hal::RobotId> in_doubt;
  std::optional<hal::kilobot::Message> question;
  bool covered = false;       // no picture comes
  int looks_for_picture = 1;  // every so many looks there is a new one
  std::string error;          // what a person must do about it
  int named_after_looks = 1;  // everybody is named from this look on, if nobody is in doubt
  int looks = 0;
  bool robots_run = false;  // as the monitor was last told
  std::vector<hal::LabTime> looked_at;
  double x_m = 0, turned_rad = 0;  // of all robots
};

class FakeMonitor final : public hal::kilobot::RobotMonitor {
 public:
  explicit FakeMonitor(std::shared_ptr<FakeTestbed> testbed) : testbed_(std::move(testbed)) {}
  void look(hal::LabTime now) override {
    ++testbed_->looks;
    testbed_->looked_at.push_back(now);
    if (testbed_->covered) return counters_.add("camera.gone");
    if (testbed_->looks % testbed_->looks_for_picture != 0) return;
    frame_.emplace();
    frame_->stamp = now;
    frame_->number = static_cast<std::uint32_t>(testbed_->looks);
    const double heading_rad = std::remainder(std::numbers::pi / 2 + testbed_->turned_rad, 2 * std::numbers::pi);
    for (const hal::RobotId robot : testbed_->robots)
      frame_->robots.push_back({robot, {testbed_->x_m, 0.1, heading_rad}, hal::Led::green, 0.9F, {}, 0.01F});
  }
  void robots_run(bool run) override { testbed_->robots_run = run; }
  std::optional<hal::PoseFrame> latest() override { return std::exchange(frame_, std::nullopt); }
  std::optional<hal::kilobot::Message> question() const override { return testbed_->question; }
  std::span<const hal::RobotId> doubtful() const override { return testbed_->in_doubt; }
  bool everybody_named() const override {
    return testbed_->in_doubt.empty() && testbed_->looks >= testbed_->named_after_looks;
  }
  std::string error() const override { return testbed_->error; }
  const hal::Counters& counters() const override { return counters_; }

 private:
  std::shared_ptr<FakeTestbed> testbed_;
  std::optional<hal::PoseFrame> frame_;
  hal::Counters counters_;
};

}  // namespace arkmesh::tests
