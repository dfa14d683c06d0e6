// How robots move: speeds, pivot, walls, pushing.
#include <cmath>
#include <numbers>

#include "hal/platforms/kilobot/body.hpp"
#include "sim_ode/contact_world.hpp"
#include "sim_ode/host/turns/reception.hpp"
#include "tests/sim_ode/arena_builder.hpp"
#include "tests/support/processes/thorough.hpp"

namespace arkmesh::sim_ode {

namespace {

constexpr double r = hal::kilobot::body_radius_m;

double distance(const hal::Pose& a, const hal::Pose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

double turned(const hal::Pose& from, const hal::Pose& to) {
  return std::remainder(to.heading_rad - from.heading_rad, 2 * std::numbers::pi);
}

// Whatever the speeds, nobody passes through anybody or goes deeper than half a millimetre.
void check_random_speeds(int arenas) {
  hal::RandomStream chance(1, "speeds");
  for (int k = 0; k < arenas; ++k) {
    CAPTURE(k);
    const double fastest = std::pow(10, chance.uniform(-2.5, 0)), turn = chance.uniform(0, 20);
    std::vector<hal::Pose> start;
    const int robots = 2 + k % 8;
    for (int i = 0; i < robots; ++i)
      start.push_back({-0.15 + 0.04 * i, chance.uniform(-0.01, 0.01), 6.28 * chance.uniform()});
    ContactWorld world(0.4, 0.2, {.solver = k % 2 ? Solver::ode : Solver::fast}, 1, start);
    double nearest = 1, outermost = 0;
    for (int tick = 0; tick < 40; ++tick) {
      for (int i = 0; i < robots; ++i)
        if (chance.below(8) == 0)
          world.set_velocity(i, {chance.uniform(-fastest, fastest), 0, chance.uniform(-turn, turn)});
      world.tick();
      for (int i = 0; i < robots; ++i) {
        outermost = std::max(outermost, std::abs(world.pose(i, 1).y_m));
        for (int j = 0; j < i; ++j) nearest = std::min(nearest, distance(world.pose(i, 1), world.pose(j, 1)));
      }
    }
    CAPTURE(fastest);
    CHECK(nearest > 2 * r - 0.0005);
    CHECK(outermost < 0.1 - r + 0.0005);
    CHECK(world.totals().deepest_m < 0.0005);
  }
}

}  // namespace

TEST_CASE("straight, left, right") {
  // Both motors: 1 cm/s straight. The first turns left, the second right, 45 deg/s about a rear leg, centre on its arc.
  auto arena = TestArena{.program = "drive.c", .side_m = 2, .ode = std::string(exact_drive) + "\nstart = \"centre80\""}
                   .make_running();
  double at = 0;
  const auto measured = [&](int motors) {
    arena->robots().command(broadcast(1, {motors}));
    const hal::Pose before = frame_at(*arena, seconds(at += 1)).robots[0].pose;
    const hal::Pose after = frame_at(*arena, seconds(at += 1)).robots[0].pose;
    return std::pair(before, after);
  };
  arena->advance_to(seconds(0.0));

  const auto [s0, s1] = measured(3);
  CHECK(distance(s0, s1) == doctest::Approx(0.01).epsilon(1e-6));
  CHECK(turned(s0, s1) == doctest::Approx(0).epsilon(1e-9));
  CHECK(std::cos(s0.heading_rad) * (s1.x_m - s0.x_m) + std::sin(s0.heading_rad) * (s1.y_m - s0.y_m) ==
        doctest::Approx(0.01).epsilon(1e-6));

  // the leg lies on a circle of 17 mm: 9.9 mm behind the centre and 13.85 mm to the side
  using hal::kilobot::rear_axle_m, hal::kilobot::rear_legs_apart_m;
  const double radius = std::hypot(rear_axle_m, rear_legs_apart_m / 2),
               chord = 2 * radius * std::sin(std::numbers::pi / 8);
  for (int motors : {1, 2}) {
    const auto [t0, t1] = measured(motors);
    const double side = motors == 1 ? 1 : -1;
    CHECK(radius == doctest::Approx(0.017).epsilon(0.002));
    CHECK(turned(t0, t1) == doctest::Approx(side * std::numbers::pi / 4).epsilon(1e-4));
    CHECK(distance(t0, t1) == doctest::Approx(chord).epsilon(1e-3));
    // the leg stays where it is
    const auto leg = [side](const hal::Pose& p) {
      const double c = std::cos(p.heading_rad), s = std::sin(p.heading_rad);
      return std::pair(p.x_m - rear_axle_m * c - side * rear_legs_apart_m / 2 * s,
                       p.y_m - rear_axle_m * s + side * rear_legs_apart_m / 2 * c);
    };
    CHECK(std::hypot(leg(t0).first - leg(t1).first, leg(t0).second - leg(t1).second) < 2e-5);
  }
  const auto [n0, n1] = measured(0);
  CHECK(distance(n0, n1) == 0);
}

TEST_CASE("spread between robots") {
  // With spread, robots told the same go at different speeds; its size is the setting's.
  DriveSettings settings;
  settings.duty_spread = 0;
  Motors motors(settings, 2000, "shark", 1);
  double sum = 0, sum2 = 0;
  for (int i = 0; i < 2000; ++i) {
    const double v = motors.velocity(i, 65, 65).ahead_m_s;
    sum += v;
    sum2 += v * v;
  }
  const double mean = sum / 2000, deviation = std::sqrt(sum2 / 2000 - mean * mean);
  CHECK(mean == doctest::Approx(0.01).epsilon(0.02));
  CHECK(deviation == doctest::Approx(0.01 * 0.186 / std::sqrt(2.0)).epsilon(0.1));  // mean of two independent sides
  settings.speed_spread = 0;
  CHECK(Motors(settings, 1, "shark", 1).velocity(0, 65, 65).ahead_m_s == doctest::Approx(0.01));
}

TEST_CASE("duty") {
  // Speed is linear in the duty around the calibrated one; nothing below 10 %.
  DriveSettings settings;
  settings.speed_spread = settings.duty_spread = 0;
  const Motors motors(settings, 1, "shark", 1);
  CHECK(motors.velocity(0, 52, 52).ahead_m_s == doctest::Approx(0.008));
  CHECK(motors.velocity(0, 25, 25).ahead_m_s == 0);
  CHECK(motors.velocity(0, 77, 0).turn_rad_s == doctest::Approx(std::numbers::pi / 4 * 1.1));
  CHECK(motors.velocity(0, 65, 52).turn_rad_s == doctest::Approx(std::numbers::pi / 4 * 0.2));
}

TEST_CASE("turn noise") {
  // A balanced robot with turn noise wanders: its turn rate has the key's s.d., changes within the correlation time and
  // not from tick to tick, and ends with its motion; other robots' changes do not disturb it.
  constexpr double degree = std::numbers::pi / 180;
  DriveSettings settings;
  settings.speed_spread = settings.duty_spread = 0;
  settings.turn_noise_deg_per_s = 5;
  settings.turn_noise_s = 1;
  Motors motors(settings, 3, "shark", 1);
  for (int robot : {0, 1, 2}) motors.connect(robot, true, 0);
  motors.end_tick();
  motors.set(1, 65, 65, 0);
  std::vector<double> rates;
  for (int k = 0; k < 20'000; ++k) {
    if (k % 7 == 0) motors.set(2, k % 2 ? 65 : 0, 65, 100);
    for (const Motors::Change& change : motors.end_tick()) {
      REQUIRE(change.robot != 0);
      if (change.robot == 1) rates.push_back(change.velocity.turn_rad_s / degree);
    }
  }
  REQUIRE(rates.size() == 20'000);
  const auto covariance = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t k = lag; k < rates.size(); ++k) sum += rates[k] * rates[k - lag];
    return sum / static_cast<double>(rates.size() - lag);
  };
  CHECK(std::sqrt(covariance(0)) == doctest::Approx(5).epsilon(0.1));
  CHECK(covariance(31) / covariance(0) == doctest::Approx(std::exp(-1.0)).epsilon(0.2));
  motors.set(1, 0, 0, 0);
  for (const Motors::Change& change : motors.end_tick())
    if (change.robot == 1) CHECK(change.velocity.still());
  for (const Motors::Change& change : motors.end_tick()) CHECK(change.robot != 1);
}

TEST_CASE("spin-up") {
  // With a start_duty a motor at rest needs it, or full power for a moment first, as spinup_motors() gives it; a
  // running one goes on down to dead_duty, and starts anew after it stood.
  DriveSettings settings;
  settings.speed_spread = settings.duty_spread = 0;
  settings.start_duty = 60;
  settings.dead_duty = 40;
  Motors motors(settings, 1, "shark", 1);
  motors.connect(0, true, 0);
  const auto ahead = [&] {
    motors.end_tick();
    const std::vector<Motors::Change>& steady = motors.end_tick();
    return steady.empty() ? 0.0 : steady[0].velocity.ahead_m_s;
  };
  const auto spin_up = [&](std::int64_t us) {
    motors.set(0, 255, 255, 1000);
    motors.set(0, 52, 52, 1000 + us);
  };
  motors.set(0, 52, 52, 100);
  CHECK(ahead() == 0);
  spin_up(5'000);
  CHECK(ahead() == 0);
  spin_up(15'000);
  CHECK(ahead() == doctest::Approx(0.008));
  motors.set(0, 45, 45, 100);
  CHECK(ahead() > 0);
  motors.set(0, 39, 39, 100);
  CHECK(ahead() == 0);
  motors.set(0, 52, 52, 100);
  CHECK(ahead() == 0);
  motors.set(0, 65, 65, 100);
  CHECK(ahead() == doctest::Approx(0.01));
}

TEST_CASE("a battery runs down") {
  // A battery of 0.1 mAh, 360 mA s, is empty after 53.7 s of 6.7 mA, and after 9.8 s when two motors at 65 of 70 x 16
  // mA run from 1 s on; by then the robot is slower, and an empty one is switched off.
  const TestArena scene{
      .program = "drive.c",
      .side_m = 2,
      .ode = std::string(exact_drive) + "\nbattery_mah = 0.1\nbattery_empty_share = 0.8\nstart_poses = [0, 0, 0]"};
  auto driving = scene.make_running(), standing = scene.make_running();
  driving->advance_to(seconds(1));
  driving->robots().command(broadcast(1, {3}));
  const auto speed = [&](int from_s) {
    const hal::Pose before = frame_at(*driving, seconds(from_s)).robots[0].pose;
    return distance(before, frame_at(*driving, seconds(from_s + 1)).robots[0].pose);
  };
  CHECK(speed(2) == doctest::Approx(0.0096).epsilon(0.02));
  CHECK(speed(8) == doctest::Approx(0.0084).epsilon(0.02));
  CHECK(driving->counters()["robots.battery_empty"] == 0);
  CHECK(speed(13) == 0);
  CHECK(driving->counters()["robots.battery_empty"] == 1);
  standing->advance_to(seconds(52));
  CHECK(standing->counters()["robots.battery_empty"] == 0);
  standing->advance_to(seconds(56));
  CHECK(standing->counters()["robots.battery_empty"] == 1);
}

TEST_CASE("a battery gives what was drawn") {
  // Whatever their rhythm, motors and LED draw their current for as long as they have it: 20 robots, whose timers have
  // 16 phases, are all empty within 5 % of the charge's time, 1080 mA s / (6.7 mA + 2 x 16 mA x duty / 70 + 1.6 mA x
  // light).
  const auto empties_at_right_time = [](const std::string& define, double duty, double light) {
    auto arena =
        TestArena{.program = "pulses.c",
                  .robots = 20,
                  .side_m = 2,
                  .ode = "battery_mah = 0.3\nspeed_m_per_s = 0\nturn_deg_per_s = 0\nspeed_spread = 0.0\ndefine = [" +
                         define + "]"}
            .make_running();
    const double right_s = 1080 / (6.7 + 2 * 16 * duty / 70 + 1.6 * light);
    CAPTURE(define);
    CAPTURE(right_s);
    arena->advance_to(seconds(0.95 * right_s));
    CHECK(arena->counters()["robots.battery_empty"] == 0);
    arena->advance_to(seconds(1.05 * right_s + 1));  // each is looked at once a second
    CHECK(arena->counters()["robots.battery_empty"] == 20);
  };
  for (const int period : {31, 37})
    for (const int light : {0, 3}) {
      if (!arkmesh::tests::thorough() && (period == 37) == (light == 0)) continue;
      empties_at_right_time(fmt::format("\"ON=3\", \"MOTOR=70\", \"PERIOD={}\", \"LIGHT={}\"", period, light),
                            3.0 / period * 70, 3.0 / period * light);
    }
  empties_at_right_time("\"ON=1\", \"MOTOR=30\", \"PERIOD=1\", \"LIGHT=0\"", 30, 0);
  empties_at_right_time("\"RANDOM=1\", \"LIGHT=0\"", 127.5, 0);
}

TEST_CASE("a wall stops") {
  // A robot that drives against a wall never gets beyond it, and slides along when it comes at an angle.
  ContactWorld world(1, 1, {.friction = 0.3}, 1, {{0.47, 0, 0}, {0, 0.47, std::numbers::pi / 3}});
  world.set_velocity(0, {0.01, 0, 0});
  world.set_velocity(1, {0.01, 0, 0});
  for (int k = 0; k < 600; ++k) world.tick();
  CHECK(world.x()[0] == doctest::Approx(0.5 - r).epsilon(1e-6));
  CHECK(world.y()[1] <= 0.5 - r + 1e-9);
  CHECK(world.x()[1] > 0.005);
  CHECK(world.totals().deepest_m < 1e-6);
}

TEST_CASE("pushing") {
  // A driving robot pushes a standing one, more slowly than it drives alone; a longer chain is slower still; nobody
  // passes through.
  double last = 0.01;
  for (int chain : {1, 2, 3, 5}) {
    std::vector<hal::Pose> start;
    for (int i = 0; i <= chain; ++i) start.push_back({-0.4 + i * (2 * r + 0.0001), 0, 0});
    ContactWorld world(1, 1, {.friction = 0.3}, 1, start);
    world.set_velocity(0, {0.01, 0, 0});
    for (int k = 0; k < 30; ++k) world.tick();
    const double x = world.x()[0];
    for (int k = 0; k < 61; ++k) world.tick();
    const double speed = (world.x()[0] - x) / (61 * tick_us * 1e-6);
    CHECK(speed < last * 0.95);
    CHECK(speed > 0.01 / (chain + 1) * 0.9);
    last = speed;
    for (int i = 0; i < chain; ++i)
      CHECK(world.x()[static_cast<std::size_t>(i) + 1] - world.x()[static_cast<std::size_t>(i)] > 2 * r - 0.0002);
  }
}

TEST_CASE("friction turns what slides past") {
  // A robot that grazes another one turns it; without friction it does not.
  for (double friction : {0.0, 0.3}) {
    ContactWorld world(1, 1, {.friction = friction}, 1, {{-0.04, 0.025, 0}, {0, 0, 0}});
    world.set_velocity(0, {0.01, 0, 0});
    for (int k = 0; k < 200; ++k) world.tick();
    CHECK(world.x()[0] > -0.005);
    const double heading = std::atan2(world.heading(1).second, world.heading(1).first);
    if (friction == 0)
      CHECK(heading == 0);
    else
      CHECK(std::abs(heading) > 0.01);
    CHECK(world.totals().deepest_m < 1e-4);
  }
}

TEST_CASE("crowds do not overlap") {
  // In a crowd of wandering robots nobody is ever deeper than 1 mm in another or in a wall.
  for (const auto& crowd : {std::pair{48, 1.0}, std::pair{100, 0.5}, std::pair{60, 0.3}}) {
    const auto& [robots, side] = crowd;
    if (!arkmesh::tests::thorough() && robots > 48) continue;
    CAPTURE(crowd.first);
    auto arena = TestArena{.robots = robots, .side_m = side}.make_running();
    double nearest = 1, outermost = 0;
    for (int k = 0; k <= 600; ++k) {
      const hal::PoseFrame frame = frame_at(*arena, seconds(0.1 * k));
      for (std::size_t i = 0; i < frame.robots.size(); ++i) {
        const hal::Pose& pose = frame.robots[i].pose;
        outermost = std::max({outermost, std::abs(pose.x_m), std::abs(pose.y_m)});
        for (std::size_t j = 0; j < i; ++j) nearest = std::min(nearest, distance(pose, frame.robots[j].pose));
      }
    }
    CHECK(nearest > 2 * r - 0.001);
    CHECK(outermost < side / 2 - r + 0.001);
    CHECK(arena->counters()["contacts.robot_ticks"] > 100);
    CHECK(arena->counters()["contacts.deeper_than_1mm"] == 0);
    MESSAGE(robots << " robots: nearest " << nearest * 1000 << " mm, outermost " << (side / 2 - outermost) * 1000
                   << " mm from the wall");
  }
}

TEST_CASE("contacts hold at every speed") {
  check_random_speeds(100);
}

TEST_CASE("contacts hold at every speed, in a thousand arenas" * doctest::skip(!arkmesh::tests::thorough())) {
  check_random_speeds(1000);
}

TEST_CASE("one great jam") {
  // 400 robots in one cluster, more than is solved in place: ODE keeps them apart and inside, twice the same.
  std::vector<hal::Pose> start;
  for (int i = 0; i < 400; ++i) start.push_back({-0.315 + 0.0332 * (i % 20), -0.315 + 0.0332 * (i / 20), 0.7 * i});
  std::vector<double> first;
  for (int run = 0; run < 2; ++run) {
    ContactWorld world(0.67, 0.67, {.friction = 0.3}, 1, start);
    for (int i = 0; i < 400; ++i) world.set_velocity(i, {0.01, 0, 0});
    for (int k = 0; k < 300; ++k) world.tick();
    CHECK(world.totals().ode_steps > 100);
    CHECK(world.totals().deepest_m < 0.001);
    if (run == 0)
      first = world.x();
    else
      CHECK(world.x() == first);
    MESSAGE("ODE steps " << world.totals().ode_steps << ", deepest " << world.totals().deepest_m * 1000 << " mm");
  }
}

TEST_CASE("start places") {
  // Robots start inside the arena or its centre, apart from each other, with the seed deciding where.
  for (const char* start : {"uniform", "centre80"}) {
    const TestArena scene{.robots = 100, .side_m = 0.6, .ode = fmt::format("start = \"{}\"", start)};
    const hal::PoseFrame frame = frame_at(*scene.make(), hal::LabTime{0});
    double outermost = 0;
    for (std::size_t i = 0; i < 100; ++i) {
      outermost = std::max({outermost, std::abs(frame.robots[i].pose.x_m), std::abs(frame.robots[i].pose.y_m)});
      for (std::size_t j = 0; j < i; ++j) CHECK(distance(frame.robots[i].pose, frame.robots[j].pose) > 2 * r);
    }
    const double bound = std::string(start) == "uniform" ? 0.3 - r : 0.24;
    CHECK(outermost <= bound);
    CHECK(outermost > 0.9 * bound);
    TestArena other = scene;
    other.seed = 2;
    CHECK(distance(frame_at(*other.make(), hal::LabTime{0}).robots[0].pose, frame.robots[0].pose) > 0);
  }
  CHECK_THROWS_AS((TestArena{.robots = 200, .side_m = 0.5, .ode = "start = \"centre80\""}.make()), hal::ConfigError);
}

}  // namespace arkmesh::sim_ode
