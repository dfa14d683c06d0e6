// Several programs in one arena, and what robots say to their lab.
#include <set>

#include "hal/types.hpp"
#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {
namespace {

std::string refusal(const TestArena& arena) {
  try {
    arena.make();
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

constexpr const char* three_roles = R"(start_poses = [0.02, 0, 0, 0.06, 0, 0, 0.1, 0, 0]
[[arena.ode.group]]
robots = 2
define = ["ROLE=2"]
start_poses = [-0.1, 0, 0, -0.06, 0, 0]
[[arena.ode.group]]
robots = 1
define = ["ROLE=3"]
start_poses = [-0.02, 0, 0])";

}  // namespace

TEST_CASE("groups run programs of their own, and hear each other over group borders") {
  // Colours say which robot was built how; each robot says whom of another group it heard first, by number in the
  // arena.
  auto arena = TestArena{.program = "role.c", .robots = 6, .ode = three_roles}.make_running();
  const hal::PoseFrame frame = frame_at(*arena, seconds(20));
  std::vector<int> leds;
  for (const hal::Observation& robot : frame.robots) leds.push_back(static_cast<int>(robot.led));
  CHECK(leds == std::vector<int>{2, 2, 4, 1, 1, 1});
  const auto heard = arena->robots().heard();
  std::set<hal::RobotId> said;
  for (const hal::FromRobot& word : heard) {
    const int role = word.robot < 2 ? 2 : word.robot == 2 ? 3 : 1, other = word.value % 1000;
    CHECK(word.kind == role);
    CHECK(word.value / 1000 == (other < 2 ? 2 : other == 2 ? 3 : 1));
    CHECK(word.value / 1000 != role);
    said.insert(word.robot);
  }
  CHECK(said == std::set<hal::RobotId>{0, 1, 2, 3, 4});  // robot 5 has only its own group in reach
  CHECK(heard.size() == 5);
  CHECK(arena->robots().heard().empty());
}

TEST_CASE("a group's robots are those that the same robots are without groups") {
  // Ids, clocks and chance: one program in three groups moves exactly as in one.
  const std::string first = "-0.2, 0, 0, -0.1, 0, 1", second = "0, 0, 2, 0.1, 0, 3, 0.2, 0, -1", last = "0.2, 0.2, -2";
  auto whole =
           TestArena{.robots = 6, .ode = fmt::format("start_poses = [{}, {}, {}]", first, second, last)}.make_running(),
       parts = TestArena{.robots = 6,
                         .ode = fmt::format("start_poses = [{}]\n[[arena.ode.group]]\nrobots = 2\nstart_poses = [{}]\n"
                                            "[[arena.ode.group]]\nrobots = 3\nstart_poses = [{}]",
                                            last, first, second)}
                   .make_running();
  const hal::PoseFrame one = frame_at(*whole, seconds(60)), other = frame_at(*parts, seconds(60));
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(one.robots[i].pose.x_m == other.robots[i].pose.x_m);
    CHECK(one.robots[i].pose.y_m == other.robots[i].pose.y_m);
    CHECK(one.robots[i].pose.heading_rad == other.robots[i].pose.heading_rad);
  }
}

TEST_CASE("groups have ids of their own, or those of the arena in turn") {
  // Robots are counted by id: a beacon's group may come first in the file and have the highest one. Each robot's
  // program, place and loops_per_tick are its group's: two show red or green after 5000 calls, the third never does.
  auto arena = TestArena{.program = "id.c", .robots = 3, .ode = R"(ids = [384]
loops_per_tick = 330
start_poses = [0.3, 0, 0]
[[arena.ode.group]]
robots = 1
ids = [10001]
loops_per_tick = 330
start_poses = [0.1, 0, 0]
[[arena.ode.group]]
robots = 1
ids = [7]
start_poses = [0.2, 0, 0])"}
                   .make_running();
  CHECK(arena->info().robots == std::vector<hal::RobotId>{7, 384, 10001});
  const hal::PoseFrame frame = frame_at(*arena, seconds(2));
  const double x[] = {0.2, 0.3, 0.1};
  const hal::Led led[] = {hal::Led::off, hal::Led::green, hal::Led::green};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(frame.robots[i].robot == arena->info().robots[i]);
    CHECK(frame.robots[i].pose.x_m == doctest::Approx(x[i]));
    CHECK(frame.robots[i].led == led[i]);
  }
  const auto with = [](const std::string& first, const std::string& second) {
    return refusal({.robots = 5,
                    .ode = "[[arena.ode.group]]\nrobots = 2\nids = " + first +
                           "\n[[arena.ode.group]]\nrobots = 2\nids = " + second});
  };
  CHECK(with("[10]", "[20, 30]") == "accepted");
  CHECK(with("[20, 30]", "[10]") == "accepted");
  CHECK(with("[10]", "[11]").find("arena.ode.group[1].ids") != std::string::npos);
  CHECK(with("[10]", "[11]").find("begin with 11, and another group's end with 11") != std::string::npos);
  CHECK(with("[10, 30]", "[20]").find("all of a group must be below or above all of another") != std::string::npos);
  CHECK(with("[0]", "[20]").find("begin with 0, and another group's end with 1") != std::string::npos);
  CHECK(with("[10, 10]", "[20]").find("must be ascending") != std::string::npos);
  CHECK(with("[10, 11, 12]", "[20]").find("must be 2 ids up to 65535, or the first of them") != std::string::npos);
}

TEST_CASE("groups that cannot be are refused by name") {
  const auto with = [](const std::string& group) {
    return refusal({.robots = 3, .ode = "[[arena.ode.group]]\n" + group});
  };
  CHECK(with("robots = 3") == "accepted");
  CHECK(with("robots = 4").find("arena.ode.group[0].robots = 4: makes more than the arena's 3 robots") !=
        std::string::npos);
  CHECK(refusal({.robots = 1, .ode = "start_poses = [0, 0, 0]\n[[arena.ode.group]]\nrobots = 1"})
            .find("places robots that are in no group, and there are none") != std::string::npos);
  CHECK(with("robots = 0").find("arena.ode.group[0].robots") != std::string::npos);
  CHECK(with("robots = 1\nstart_poses = [0, 0, 0, 0.2, 0, 0]").find("holds 2 places for 1 robot") != std::string::npos);
  CHECK(with("robots = 1\ncontroller = \"nowhere.c\"").find("nowhere.c") != std::string::npos);
  CHECK(with("robots = 1\ndefine = [\"1X\"]").find("arena.ode.group[0].define") != std::string::npos);
  CHECK(with("robots = 1\ncolour = 3").find("arena.ode.group[0].colour") != std::string::npos);
}

}  // namespace arkmesh::sim_ode
