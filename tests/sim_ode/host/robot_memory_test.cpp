// Robots' copies of a program's memory, without a program.
#include "sim_ode/host/turns/robot_memory.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>

namespace arkmesh::sim_ode {
namespace {

struct OneRobot {
  std::uint32_t count = 7;
  std::uint8_t rest[124] = {};
};
static_assert(sizeof(OneRobot) == 128);

struct Place {
  alignas(64) OneRobot now;
  std::array<std::byte, sizeof(OneRobot)> first{};
  Place() { std::memcpy(first.data(), &now, sizeof now); }
  RobotMemory memory(int robots) { return {reinterpret_cast<char*>(&now), first, robots}; }
};

}  // namespace

TEST_CASE("robot memory: each robot has its own") {
  // What one robot's turn leaves in place is there again in its next turn, whatever others did in between.
  Place place;
  RobotMemory memory = place.memory(3);
  for (int robot = 0; robot < 3; ++robot) {
    memory.start_anew();
    place.now.count += static_cast<std::uint32_t>(robot);
    place.now.rest[123] = static_cast<std::uint8_t>(100 + robot);
    memory.copy_out(robot);
  }
  for (int turn = 0; turn < 2; ++turn)
    for (int robot = 2; robot >= 0; --robot) {
      memory.copy_in(robot);
      CHECK(place.now.count == static_cast<std::uint32_t>(7 + robot + turn));
      CHECK(place.now.rest[123] == 100 + robot);
      ++place.now.count;
      memory.copy_out(robot);
    }
}

TEST_CASE("robot memory: started anew") {
  // Power-up gives the first memory again, to one robot alone.
  Place place;
  RobotMemory memory = place.memory(2);
  for (int robot = 0; robot < 2; ++robot) {
    place.now.count = 50;
    memory.copy_out(robot);
  }
  memory.start_anew();
  CHECK(place.now.count == 7);
  memory.copy_out(1);
  memory.copy_in(0);
  CHECK(place.now.count == 50);
  memory.copy_in(1);
  CHECK(place.now.count == 7);
}

TEST_CASE("robot memory: a robot's variable from outside") {
  // Read and written in the robot's copy; what is in place stays.
  Place place;
  RobotMemory memory = place.memory(2);
  memory.copy_out(0);
  memory.copy_out(1);
  memory.write(1, &place.now.count, std::uint32_t{9});
  memory.write(1, &place.now.rest[60], std::uint8_t{4});
  CHECK(memory.read(0, &place.now.count) == 7);
  CHECK(memory.read(1, &place.now.count) == 9);
  CHECK(place.now.count == 7);
  memory.copy_in(1);
  CHECK(place.now.count == 9);
  CHECK(place.now.rest[60] == 4);
}

}  // namespace arkmesh::sim_ode
