// What robots say to robots of all labs within range.
#include "scenarios/kit/voices.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "hal/random.hpp"
#include "lab/testing/lab_double.hpp"

namespace arkmesh::scenarios::kit {
namespace {

constexpr int values = 3;
constexpr double range_m = 0.2;

// Robot r says r modulo 4, of which 3 is none of the values.
struct Talkers final : lab::Scenario {
  explicit Talkers(Voices made = {"talk", values, range_m}) : voices(std::move(made)) {}
  Voices voices;

  void begin(lab::Lab& lab) override { voices.begin(lab); }
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override {
    for (const hal::Observation& robot : frame.robots) voices.say(robot.robot, static_cast<int>(robot.robot % 4));
    voices.tell(lab);
  }
  void on_period(lab::Lab& lab) override { voices.on_period(lab); }
  void on_heard(lab::Lab&, std::span<const hal::FromRobot>) override {}
  bool finished(const lab::Lab&) const override { return false; }
};

}  // namespace

TEST_CASE("kit: robots hear what others within range say, whichever their lab is") {
  std::map<std::string, Talkers*> talkers;
  lab::WorldDouble labs({{"a", 1, {}}, {"b", 1, {.shift_x_m = 0.3, .turn_rad = 0.8}}}, "a");
  labs.begin([&](const std::string& lab) {
    auto made = std::make_unique<Talkers>();
    talkers[lab] = made.get();
    return made;
  });
  hal::RandomStream random(1, "test/voices");
  for (int round = 0; round < 100; ++round) {
    std::map<std::string, hal::PoseFrame> frames;
    for (const std::string& name : labs.names()) {
      for (hal::RobotId robot = 0; robot < 20; ++robot)
        frames[name].robots.push_back({robot, {random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0}});
      labs[name].frame(frames[name]);
    }
    labs.boundary();
    for (const std::string& name : labs.names()) {
      const auto heard = talkers[name]->voices.heard(labs[name].lab, frames[name]);
      for (std::size_t robot = 0; robot < 20; ++robot) {
        const hal::Pose here = labs[name].lab.projection().to_shared(frames[name].robots[robot].pose);
        std::vector<int> expected(values, 0);
        for (const std::string& other : labs.names())
          for (const hal::Observation& speaker : frames[other].robots) {
            const hal::Pose there = labs[other].lab.projection().to_shared(speaker.pose);
            if ((other == name && speaker.robot == robot) || speaker.robot % 4 == 3) continue;
            if (std::hypot(there.x_m - here.x_m, there.y_m - here.y_m) <= range_m) ++expected[speaker.robot % 4];
          }
        for (std::size_t value = 0; value < values; ++value) CHECK(heard[robot * values + value] == expected[value]);
      }
    }
  }
}

TEST_CASE("kit: robots that a graph joins hear each other wherever they are") {
  // robot n of either lab is joined to robot n + 1 of both
  std::vector<std::pair<Voices::Robot, Voices::Robot>> graph;
  for (hal::RobotId robot = 0; robot + 1 < 8; ++robot)
    for (const char* to : {"a", "b"})
      for (const char* from : {"a", "b"}) graph.push_back({{from, robot}, {to, robot + 1}});
  graph.push_back(graph.front());
  std::map<std::string, Talkers*> talkers;
  lab::WorldDouble labs({{"a", 1, {}}, {"b", 1, {.shift_x_m = 50}}}, "a");
  labs.begin([&](const std::string& lab) {
    auto made = std::make_unique<Talkers>(Voices("talk", values, graph));
    talkers[lab] = made.get();
    return made;
  });
  hal::PoseFrame frame;
  for (hal::RobotId robot = 0; robot < 8; ++robot) frame.robots.push_back({robot, {0.1 * robot, 0, 0}});
  for (const std::string& name : labs.names()) labs[name].frame(frame);
  labs.boundary();
  for (const std::string& name : labs.names()) {
    const auto heard = talkers[name]->voices.heard(labs[name].lab, frame);
    for (int robot = 0; robot < 8; ++robot) {
      std::vector<int> expected(values, 0);
      for (const int other : {robot - 1, robot + 1})
        if (other >= 0 && other < 8 && other % 4 != 3) expected[static_cast<std::size_t>(other % 4)] += 2;
      for (int value = 0; value < values; ++value)
        CHECK(heard[static_cast<std::size_t>(robot * values + value)] == expected[static_cast<std::size_t>(value)]);
    }
  }
  CHECK_THROWS_WITH_AS(Voices("talk", 2, {{{"a", 1}, {"a", 1}}}), "robot 1 of a is joined to itself in a graph",
                       std::invalid_argument);
  lab::WorldDouble alone({{"a", 1, {}}}, "a");
  CHECK_THROWS_WITH_AS(
      alone.begin([&](const std::string&) { return std::make_unique<Talkers>(Voices("talk", values, graph)); }),
      "a graph joins robot 0 of b, and the labs are a", std::invalid_argument);
}

TEST_CASE("kit: voices that are none are refused in one sentence") {
  CHECK_THROWS_WITH_AS(Voices("talk", 65, 1), "voices say one of 65 values; give 1 to 64", std::invalid_argument);
  CHECK_THROWS_WITH(Voices("talk", 2, 0), "nobody hears voices within 0 m; give a positive range");
}

}  // namespace arkmesh::scenarios::kit
