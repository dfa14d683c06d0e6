// The small scenario of the documentation: by itself, and the whole way with simulated labs.
#include "scenarios/light_up/light_up.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "app/joint_run.hpp"
#include "lab/testing/lab_double.hpp"

using namespace arkmesh;
using hal::Led;
using lab::WorldDouble;
using scenarios::light_up::LightUp;

TEST_CASE("light up: the projection decides who is near") {
  // Lab b is seen at scale 2: a robot 4 cm from its arena's centre is 8 cm from a robot at the shared centre and is
  // lit, one at 6 cm is 12 cm away and stays dark; lab a, the owner, tells its robots nothing.
  WorldDouble world({{"a", 1.0, {}}, {"b", 0.5, {.scale = 2}}}, "a");
  world.begin(
      [](const std::string&) { return std::make_unique<LightUp>(scenarios::light_up::Settings{.reach_m = 0.10}); });
  const auto frame = [&](Led led) {
    return hal::PoseFrame{.stamp = world.now() + hal::LabTime(100'000),
                          .number = 1,
                          .robots = {{.robot = 1, .pose = {0.04, 0, 0}, .led = led},
                                     {.robot = 2, .pose = {0, 0.06, 0}, .led = Led::off}}};
  };
  world["a"].frame(
      {.stamp = hal::LabTime(100'000), .number = 1, .robots = {{.robot = 0, .pose = {}, .led = Led::off}}});
  world.boundary();
  world["b"].frame(frame(Led::off));
  REQUIRE(world["b"].said.size() == 1);
  CHECK(world["b"].said[0].robot == 1);
  CHECK(world["b"].said[0].kind == LightUp::lit);
  CHECK(world["a"].said.empty());
  // Once it shows, no more is said; when lab a's robot is gone it is told to be dark.
  world["b"].said.clear();
  world["b"].frame(frame(Led::white));
  CHECK(world["b"].said.empty());
  world["a"].frame({.stamp = world.now() + hal::LabTime(100'000), .number = 2, .robots = {}});
  world.boundary();
  world["b"].frame(frame(Led::white));
  REQUIRE(world["b"].said.size() == 1);
  CHECK(world["b"].said[0].kind == LightUp::dark);
  CHECK(world["a"].lab.counts()["lit_periods"] == 1);
}

TEST_CASE("light up: the same in Python has the same hash") {
  // Proves that a scenario in Python sees and says, bit for bit, what one in C++ does; rerun from the folder, too.
  ::setenv("ARKMESH_PYTHON", "/usr/bin/python3", 1);
  const std::filesystem::path files = std::filesystem::path(ARKMESH_SOURCE_DIR) / "experiments/light_up",
                              folder = std::filesystem::temp_directory_path() /
                                       fmt::format("arkmesh-light-up-python-{}", ::getpid());
  const auto hash_of = [&](const std::filesystem::path& a, const std::filesystem::path& b, const std::string& scenario,
                           const std::string& out) {
    std::vector<hal::Config> configs;
    for (const auto& file : {a, b}) {
      std::vector<std::string> sets{"run.duration_s=20", "recorder.log=false"};
      if (!scenario.empty()) sets.push_back("run.scenario=" + scenario);
      configs.push_back(hal::Config::from_file(file, sets));
    }
    app::JointRun run(std::move(configs), folder / out);
    while (run.step()) {
    }
    CHECK(run.finished());
    CHECK(run.lab("b").runner().lab().counts()["lit_periods"] > 0);
    return run.lab("a").runner().final_hash();
  };
  const std::uint64_t in_python = hash_of(files / "a.toml", files / "b.toml", "", "python");
  CHECK(hash_of(files / "a.toml", files / "b.toml", "light_up", "cpp") == in_python);
  CHECK(hash_of(folder / "python/a/config.toml", folder / "python/b/config.toml", "", "again") == in_python);
  std::filesystem::remove_all(folder);
}

TEST_CASE("light up: simulated labs") {
  // Over two minutes of two simulated labs, robots of b that are well within reach of a robot of a glow, and those well
  // out of reach are dark, as both labs see it in their merged states; and the reverse never happens to lab a.
  const auto lab = [](const std::string& name, double side_m) {
    return hal::Config::from_text(
        fmt::format("[lab]\nname = \"{0}\"\n[run]\nscenario = \"light_up\"\nduration_s = 120\n[gate]\nperiod_s = 0.2\n"
                    "[shared]\nlabs = [\"a\", \"b\"]\nowner = \"a\"\n[shared.projection.b]\nscale = 2\n"
                    "[recorder]\nlog = false\n[arena]\nrobots = 12\nwidth_m = {1}\nheight_m = {1}\n"
                    "[arena.ode]\ncontroller = \"{2}/experiments/light_up/light_up.c\"\n",
                    name, side_m, ARKMESH_SOURCE_DIR),
        name + ".toml");
  };
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("arkmesh-light-up-{}", ::getpid());
  std::vector<hal::Config> configs;
  configs.push_back(lab("a", 1.0));
  configs.push_back(lab("b", 0.5));
  app::JointRun run(std::move(configs), folder);
  const lab::Lab& a = run.lab("a").runner().lab();
  int near = 0, near_lit = 0, far = 0, far_lit = 0;
  std::uint32_t period = 0;
  while (run.step()) {
    // After each merge, past the first seconds: what both labs showed at that boundary. Within the second that a
    // message may take, robots of a and b come 3 cm nearer at most, and pushed ones a little more.
    if (a.period() == period || a.period() < 20) continue;
    period = a.period();
    for (const lab::SharedRobot& robot : a.state("a").robots) CHECK(robot.led == Led::off);
    for (const lab::SharedRobot& robot : a.state("b").robots) {
      double nearest_m = 10;
      for (const lab::SharedRobot& other : a.state("a").robots)
        nearest_m = std::min(nearest_m, std::hypot(robot.in_shared.x_m - other.in_shared.x_m,
                                                   robot.in_shared.y_m - other.in_shared.y_m));
      if (nearest_m < 0.06) ++near, near_lit += robot.led == Led::white;
      if (nearest_m > 0.14) ++far, far_lit += robot.led == Led::white;
    }
  }
  CHECK(run.finished());
  MESSAGE(near, " observations near, ", far, " far");
  CHECK(near > 100);
  CHECK(far > 100);
  CHECK(near_lit == near);
  CHECK(far_lit == 0);
  std::filesystem::remove_all(folder);
}
