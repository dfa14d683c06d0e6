// Lab values to LCM messages and back.
#include "hal/arenas/messages.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace arkmesh;
using namespace arkmesh::hal;

TEST_CASE("a pose frame survives the way through its message") {
  // Every field of every observation, at the limits of its type.
  PoseFrame frame;
  frame.stamp = LabTime{1'800'000'000};
  frame.number = 18'000;
  frame.robots = {{0, {-0.5, 0.25, -3.14}, Led::off, 0.0F, LabTime{0}},
                  {1022, {1e-9, -0.0, 3.14}, Led::unknown, 1.0F, LabTime{123}}};
  const auto messages = to_messages(frame);
  REQUIRE(messages.size() == 1);
  const PoseFrame back = from_message(messages[0]);
  CHECK(back.stamp == frame.stamp);
  CHECK(back.number == frame.number);
  REQUIRE(back.robots.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(back.robots[i].robot == frame.robots[i].robot);
    CHECK(back.robots[i].pose.x_m == frame.robots[i].pose.x_m);
    CHECK(back.robots[i].pose.y_m == frame.robots[i].pose.y_m);
    CHECK(back.robots[i].pose.heading_rad == frame.robots[i].pose.heading_rad);
    CHECK(back.robots[i].led == frame.robots[i].led);
    CHECK(back.robots[i].confidence == frame.robots[i].confidence);
    CHECK(back.robots[i].age == frame.robots[i].age);
  }
}

TEST_CASE("an age that its field cannot hold is the longest that it can") {
  PoseFrame frame;
  frame.robots = {{.robot = 1, .age = LabTime{3'600'000'000}}};
  CHECK(from_message(to_messages(frame)[0]).robots[0].age == LabTime{2'147'483'647});
}

TEST_CASE("frames are split at 1000 robots") {
  // Sizes around the limit; the parts share number and stamp, count up and hold every robot once, in order.
  for (const std::size_t robots : {0, 1, 999, 1000, 1001, 2000, 2001}) {
    CAPTURE(robots);
    PoseFrame frame;
    frame.number = 5;
    frame.stamp = LabTime{500'000};
    for (std::size_t i = 0; i < robots; ++i)
      frame.robots.push_back({static_cast<RobotId>(i), {}, Led::off, 1, LabTime{0}});
    const auto parts = to_messages(frame);
    CHECK(parts.size() == std::max<std::size_t>(1, (robots + 999) / 1000));
    std::size_t next = 0;
    for (std::size_t part = 0; part < parts.size(); ++part) {
      CHECK(parts[part].part == static_cast<int>(part));
      CHECK(parts[part].parts == static_cast<int>(parts.size()));
      CHECK(parts[part].number == 5);
      CHECK(parts[part].stamp_us == 500'000);
      CHECK(parts[part].robots.size() <= 1000);
      for (const robot_pose_t& pose : parts[part].robots) CHECK(pose.robot == static_cast<int>(next++));
    }
    CHECK(next == robots);
  }
}

TEST_CASE("messages to and from robots keep their values") {
  // Values above 32767 too, although LCM knows no unsigned ones.
  const std::vector<ToRobot> said{{1, 2, 3, 4},
                                  {65'535, 255, 15, (1 << 24) - 1},
                                  {.robot = 5, .slot = 6, .whole = WholeMessage{127, {0, 1, 2, 128, 4, 5, 6, 7, 255}}},
                                  {.robot = everyone, .whole = WholeMessage{.type = 0}}};
  const to_robots_t message = to_message(said, LabTime{7}, 9);
  CHECK(message.stamp_us == 7);
  CHECK(message.frame == 9);
  const auto back = from_message(message);
  REQUIRE(back.size() == said.size());
  for (std::size_t i = 0; i < said.size(); ++i) {
    CHECK(back[i].robot == said[i].robot);
    CHECK(back[i].slot == said[i].slot);
    CHECK(back[i].kind == said[i].kind);
    CHECK(back[i].value == said[i].value);
    CHECK(back[i].whole == said[i].whole);
  }
  const std::vector<FromRobot> heard{{3, 4, -5}};
  const from_robots_t from = to_message(heard, LabTime{8});
  CHECK(from.stamp_us == 8);
  REQUIRE(from.messages.size() == 1);
  CHECK(from.messages[0].robot == 3);
  CHECK(from.messages[0].kind == 4);
  CHECK(from.messages[0].value == -5);
}

TEST_CASE("fleet commands come back, unknown ones do not") {
  // The seven kinds with payload; the next number and types above 127 are refused.
  for (int kind = 0; kind <= 6; ++kind) {
    FleetCommand command;
    command.kind = static_cast<FleetCommand::Kind>(kind);
    command.type = 120;
    command.data = {1, 2, 3, 4, 5, 6, 7, 8, 255};
    const auto back = from_message(to_message(command, LabTime{1}));
    REQUIRE(back);
    CHECK(back->kind == command.kind);
    CHECK(back->type == 120);
    CHECK(back->data == command.data);
  }
  fleet_command_t message = to_message(FleetCommand{}, LabTime{0});
  message.command = 7;
  CHECK(!from_message(message));
  message.command = 6;
  message.type = 128;
  CHECK(!from_message(message));
}

TEST_CASE("arena and counters become messages") {
  // Counters ascend by name.
  ArenaInfo info;
  info.max_robot = 1022;
  info.name = "shark";
  info.platform = "ode";
  info.width_m = 1.5;
  info.body_radius_m = 0.02;
  info.make = "thymio";
  static_cast<RobotKind&>(info).height_m = 0.05;
  info.robots = {1, 5};
  info.can_wait = false;
  const arena_info_t message = to_message(info);
  CHECK(message.lab == "shark");
  CHECK(message.platform == "ode");
  CHECK(message.width_m == 1.5);
  CHECK(message.body_radius_m == 0.02);
  CHECK(message.make == "thymio");
  CHECK(message.body_height_m == 0.05);
  CHECK(message.robots == 2);
  CHECK(message.max_robot == 1022);
  CHECK(message.frame_period_us == 100'000);
  CHECK(message.can_wait == 0);
  Counters counters;
  counters.add("b.x", 3);
  counters.add("a");
  const auto list = to_message(counters);
  REQUIRE(list.size() == 2);
  CHECK(list[0].name == "a");
  CHECK(list[1].name == "b.x");
  CHECK(list[1].value == 3);
}

TEST_CASE("lab names are short and plain") {
  // 1 to 15 of a-z 0-9 _ -, so that lab/channel fits into LCM's 63 bytes.
  for (const char* good : {"a", "shark", "lab-2_b", "abcdefghijklmno"}) CHECK_MESSAGE(is_lab_name(good), good);
  for (const char* bad : {"", "Shark", "a b", "a/b", "a.b", "abcdefghijklmnop", "lab\n", "\xc3\xa9"})
    CHECK_MESSAGE(!is_lab_name(bad), bad);
}
