// A lab's recording for tests: frames each 0.1 s of lab time, each with three robots.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "arkmesh/pose_frame_t.hpp"
#include "hal/record/recorder.hpp"

namespace arkmesh::tests {

inline pose_frame_t recorded_frame(int number) {
  pose_frame_t frame{};
  frame.stamp_us = number * 100'000;
  frame.number = number;
  frame.parts = 1;
  frame.n_robots = 3;
  frame.robots.resize(3);
  for (int i = 0; i < 3; ++i) {
    robot_pose_t& robot = frame.robots[static_cast<std::size_t>(i)];
    robot.robot = 10 * i;
    robot.x_m = 0.1 / (number + 1) + i;
    robot.y_m = -1.0 / 3 * number;
    robot.heading_rad = 0.7;
    robot.led = static_cast<std::int8_t>((number + i) % 8);
    robot.confidence = 0.9F;
    robot.age_us = i;
  }
  return frame;
}

inline void record_lab(const std::filesystem::path& folder, const std::string& lab, int frames) {
  hal::Recorder recorder(folder, 1'700'000'000'000'000, {});
  for (int n = 0; n < frames; ++n) {
    const pose_frame_t frame = recorded_frame(n);
    std::vector<std::byte> bytes(static_cast<std::size_t>(frame.getEncodedSize()));
    frame.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    recorder.record(hal::LabTime{n * 100'000}, "poses", bytes);
  }
  std::ofstream(folder / "result.json") << R"({"lab": ")" << lab << R"(", "state": "finished", "arkmesh": "0.1.0"})";
}

}  // namespace arkmesh::tests
