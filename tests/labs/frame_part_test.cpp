// Which part of a frame a message on a lab's bus is, also one that came from a network.
#include "app/live/frame_part.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <vector>

#include "hal/arenas/messages.hpp"

using namespace arkmesh;

namespace {

std::vector<std::byte> encoded(const pose_frame_t& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace

TEST_CASE("a frame of 2500 robots is told to be three parts, and what is no part stands alone") {
  hal::PoseFrame frame;
  frame.stamp = hal::LabTime{7};
  frame.number = 9;
  for (hal::RobotId i = 0; i < 2500; ++i) frame.robots.push_back({.robot = i});
  const auto messages = hal::to_messages(frame);
  REQUIRE(messages.size() == 3);
  for (std::int32_t i = 0; i < 3; ++i) {
    const auto told = app::frame_part("poses", encoded(messages[static_cast<std::size_t>(i)]));
    REQUIRE(told);
    CHECK(told->stamp_us == 7);
    CHECK(told->part.frame == 9);
    CHECK(told->part.part == i);
    CHECK(told->part.parts == 3);
  }
  const auto bytes = encoded(messages.back());
  CHECK_FALSE(app::frame_part("shared", bytes));
  CHECK_FALSE(app::frame_part("poses", std::span(bytes).first(27)));
  CHECK_FALSE(app::frame_part("poses", std::vector<std::byte>(100)));
  for (const auto& [part, parts] : {std::pair{3, 3}, {-1, 3}, {0, 0}, {0, -1}}) {
    pose_frame_t wrong = messages.front();
    wrong.part = part;
    wrong.parts = parts;
    CHECK_FALSE(app::frame_part("poses", encoded(wrong)));
  }
}
