// The example's arena: who is who, answers, and what a bad line, a hand and an end do to it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "tests/examples/rover/rover_arena.hpp"
#include "tests/examples/rover/simulated_rovers.hpp"

using namespace arkmesh;
using namespace arkmesh::examples::rover;
using hal::LabTime;

namespace {

// Time that passes when somebody waits.
class VirtualTime final : public hal::WallTime {
 public:
  hal::TimePoint now() override { return now_; }
  void wait_until(hal::TimePoint then) override { now_ = std::max(now_, then); }

 private:
  hal::TimePoint now_ = hal::TimePoint(std::chrono::hours(1));
};

// A testbed with rovers, and the arena around it.
struct Bench {
  VirtualTime wall;
  std::shared_ptr<SimulatedRovers> rovers;
  std::unique_ptr<hal::Arena> arena;

  explicit Bench(double damage, const std::string& keys = "") {
    const hal::Config config =
        hal::Config::from_text("[arena]\nrobots = 6\nwidth_m = 0.9\nheight_m = 0.6\n" + keys, "");
    rovers = std::make_shared<SimulatedRovers>(
        SimulatedRovers::Settings{.width_m = 0.9, .height_m = 0.6, .robots = 6, .damage = damage}, wall);
    arena = make_rover_arena(config.root().section("arena"), "lab", rovers, rovers, wall);
  }
  // The next frame that is due at that time.
  hal::PoseFrame frame(LabTime t) {
    hal::advance(*arena, t, hal::nobody_stops(), wall);
    auto frame = arena->poses().latest();
    REQUIRE(frame);
    return *frame;
  }
};

// Each rover of the frame is the one that is there.
void check_names(const hal::PoseFrame& frame, const SimulatedRovers& rovers) {
  for (const hal::Observation& seen : frame.robots) {
    const hal::Pose true_pose = rovers.where(seen.robot);
    CHECK(std::hypot(seen.pose.x_m - true_pose.x_m, seen.pose.y_m - true_pose.y_m) < 1e-9);
  }
}

}  // namespace

TEST_CASE("rovers: each is found by its light, also on a bad line") {
  // Six rovers get their own names and keep them for a minute on the way, in which all of them drive.
  for (double damage : {0.0, 0.01, 0.05}) {
    CAPTURE(damage);
    Bench bench(damage);
    const hal::PoseFrame first = bench.frame(LabTime{0});
    CHECK(first.robots.size() == 6);
    check_names(first, *bench.rovers);
    CHECK_FALSE(bench.rovers->driving());
    bench.arena->robots().command({hal::FleetCommand::Kind::run});
    for (int n = 1; n <= 600; ++n) {
      const hal::PoseFrame frame = bench.frame(n * LabTime{100'000});
      REQUIRE(frame.robots.size() == 6);
      check_names(frame, *bench.rovers);
      for (std::size_t i = 0; n == 30 && i < 6; ++i)
        CHECK(std::hypot(frame.robots[i].pose.x_m - first.robots[i].pose.x_m,
                         frame.robots[i].pose.y_m - first.robots[i].pose.y_m) > 0.05);
    }
    CHECK(bench.rovers->driving());
    CHECK((bench.arena->counters()["from_robots.damaged_bytes"] > 0) == (damage > 0));
    CHECK((bench.rovers->damaged_bytes() > 0) == (damage > 0));
  }
}

TEST_CASE("rovers: answers come back, and damaged ones do not") {
  // Each rover answers what it was told with the same kind and value; on a bad line some answers are missing and none
  // is wrong.
  for (double damage : {0.0, 0.02}) {
    CAPTURE(damage);
    Bench bench(damage);
    bench.frame(LabTime{0});
    bench.arena->robots().heard();
    std::map<hal::RobotId, int> heard;
    int right = 0, all = 0;
    for (int n = 1; n <= 100; ++n) {
      std::vector<hal::ToRobot> said;
      for (hal::RobotId robot = 0; robot < 6; ++robot)
        said.push_back({robot, 0, static_cast<std::uint8_t>(n % 8), static_cast<std::uint16_t>(100 * robot + n)});
      bench.arena->robots().offer(said);
      bench.frame(n * LabTime{100'000});
      for (const hal::FromRobot& answer : bench.arena->robots().heard()) {
        ++all;
        ++heard[answer.robot];
        right += answer.kind == n % 8 && answer.value == static_cast<int>(100 * answer.robot) + n;
      }
    }
    CHECK(bench.arena->robots().airtime().sent == 600);
    CHECK(heard.size() == 6);
    CHECK(right == all);
    if (damage == 0) CHECK(all == 600);
    if (damage > 0) CHECK((all > 200 && all < 600));
  }
}

TEST_CASE("rovers: one that was away is asked again who it is") {
  // A rover that is away for a second is not in the frames, each of which counts it, and the others keep their names;
  // put back, it has its own again within a second.
  Bench bench(0.01);
  bench.frame(LabTime{0});
  bench.arena->robots().command({hal::FleetCommand::Kind::run});
  for (int n = 1; n <= 20; ++n) bench.frame(n * LabTime{100'000});
  CHECK(bench.arena->counters()["poses.lost.robot"] == 0);
  bench.rovers->remove(2);
  hal::PoseFrame frame = bench.frame(LabTime{2'100'000});
  CHECK(frame.robots.size() == 5);
  check_names(frame, *bench.rovers);
  for (int n = 22; n <= 30; ++n) bench.frame(n * LabTime{100'000});
  CHECK(bench.arena->counters()["poses.lost.robot"] == 10);
  bench.rovers->bring_back(2);
  for (int n = 31; n <= 40; ++n) frame = bench.frame(n * LabTime{100'000});
  CHECK(frame.robots.size() == 6);
  check_names(frame, *bench.rovers);
}

TEST_CASE("rovers: an arena whose rovers do not answer says which") {
  // Nobody answers on a line that changes every byte.
  Bench bench(1, "[arena.rover]\nnames_within_s = 0.5\n");
  CHECK_FALSE(bench.arena->advance_to(LabTime{0}));
  CHECK(bench.arena->waiting_for().find("6 of 6 have not shown their light (0, 1, 2, 3, 4, 5)") != std::string::npos);
  CHECK_THROWS_WITH(hal::advance(*bench.arena, LabTime{0}, hal::nobody_stops(), bench.wall),
                    "gave up waiting for the rovers: 6 of 6 have not shown their light (0, 1, 2, 3, 4, 5); are they "
                    "switched on and in sight?");
}

TEST_CASE("rovers: the end stops them") {
  // Driving rovers stand after end(), on a bad line, too, and also when an arena is destroyed without it; on a dead
  // line end() gives up after a second.
  for (bool asked : {true, false}) {
    CAPTURE(asked);
    Bench bench(0.05);
    bench.frame(LabTime{0});
    bench.arena->robots().command({hal::FleetCommand::Kind::run});
    for (int n = 1; n <= 5; ++n) bench.frame(n * LabTime{100'000});
    REQUIRE(bench.rovers->driving());
    if (asked)
      hal::end(*bench.arena, bench.wall);
    else
      bench.arena.reset();
    CHECK_FALSE(bench.rovers->driving());
  }
  Bench dead(1);
  const auto begun = dead.wall.now();
  hal::end(*dead.arena, dead.wall);
  CHECK(dead.wall.now() - begun > std::chrono::milliseconds(900));
  CHECK(dead.wall.now() - begun < std::chrono::milliseconds(1200));
}
