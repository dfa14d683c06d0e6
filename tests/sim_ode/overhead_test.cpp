// The overhead controller in the simulated arena: airtime, when programs hear it, loss.
#include <cmath>

#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {

namespace {

bool adds_up(const hal::Airtime& a) {
  return a.offered == a.sent + a.replaced + a.refused + a.not_sent + a.waiting;
}

}  // namespace

TEST_CASE("airtime") {
  // One composite of three robots each 55 ms, at n x 55 ms exactly: 100 robots take 34 composites, 1.87 s.
  auto arena = TestArena{.robots = 100, .side_m = 1}.make();
  arena->advance_to(seconds(0.1));
  std::vector<hal::ToRobot> all;
  for (hal::RobotId id = 0; id < 100; ++id) all.push_back({id, 0, 1, 1});
  arena->robots().offer(all);
  // composites at 110, 165, ... ms
  const std::pair<std::int64_t, std::uint64_t> expected[] = {
      {109'999, 0}, {110'000, 3}, {164'999, 3}, {165'000, 6}, {1'924'999, 99}, {1'925'000, 100}, {5'000'000, 100}};
  for (const auto& [us, sent] : expected) {
    arena->advance_to(hal::LabTime{us});
    const hal::Airtime air = arena->robots().airtime();
    CHECK(air.sent == sent);
    CHECK(air.waiting == 100 - sent);
    CHECK(adds_up(air));
  }
}

TEST_CASE("messages reach programs") {
  // A robot that drives by broadcast starts in the tick after the composite, not before.
  auto arena = TestArena{.program = "drive.c",
                         .ode = std::string(exact_drive) + "\nstart = \"centre80\"",
                         .arena = "frame_period_s = 0.001"}
                   .make_running();
  arena->robots().command(broadcast(1, {3}));
  const hal::Pose start = frame_at(*arena, hal::LabTime{0}).robots[0].pose;
  // RUN at 55 ms, heard at tick 2 (65.536 ms); the broadcast at 110 ms, heard at tick 4 (131.072 ms)
  CHECK(frame_at(*arena, seconds(0.131)).robots[0].pose.x_m == start.x_m);
  CHECK(frame_at(*arena, seconds(0.132)).robots[0].pose.x_m != start.x_m);
}

TEST_CASE("loss") {
  // overhead_loss is the share of robots that miss a composite; fleet commands reach everybody.
  auto arena =
      TestArena{.program = "all_ahead.c", .robots = 100, .side_m = 1.5, .ode = "overhead_loss = 0.3"}.make_running();
  const hal::PoseFrame start = frame_at(*arena, hal::LabTime{0});
  const hal::PoseFrame later = frame_at(*arena, seconds(1));
  for (std::size_t i = 0; i < 100; ++i) CHECK(later.robots[i].pose.x_m != start.robots[i].pose.x_m);
  for (int k = 0; k < 50; ++k) {
    arena->robots().offer(std::vector<hal::ToRobot>{{0, 0, 1, 1}});
    arena->advance_to(seconds(1 + 0.055 * (k + 1)));
  }
  const double share = static_cast<double>(arena->counters()["to_robots.lost.overhead"]) / (50 * 100);
  CHECK(share == doctest::Approx(0.3).epsilon(0.1));
}

TEST_CASE("loss by place") {
  // With overhead_loss_edge robots lose more the farther they are from the arena's centre: in a corner nearly that
  // share, in the centre overhead_loss.
  const auto lost = [](const char* place) {
    auto arena = TestArena{.ode = std::string("overhead_loss_edge = 0.5\nspeed_m_per_s = 0.0\nstart_poses = ") + place}
                     .make_running();
    arena->advance_to(seconds(1));
    for (int k = 0; k < 400; ++k) {
      arena->robots().offer(std::vector<hal::ToRobot>{{0, 0, 1, 1}});
      arena->advance_to(seconds(1 + 0.055 * (k + 1)));
    }
    return static_cast<double>(arena->counters()["to_robots.lost.overhead"]) / 400;
  };
  CHECK(lost("[0, 0, 0]") == 0);
  CHECK(std::abs(lost("[0.35, 0.35, 0]") - 0.245) < 0.07);  // half of it at 0.7 of the way
  CHECK(std::abs(lost("[0.48, 0.48, 0]") - 0.461) < 0.08);
}

}  // namespace arkmesh::sim_ode
