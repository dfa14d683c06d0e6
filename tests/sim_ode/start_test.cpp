// Where robots stand at the beginning.
#include <string>

#include "tests/sim_ode/arena_builder.hpp"

namespace arkmesh::sim_ode {

TEST_CASE("places by hand") {
  // Robots stand where start_poses puts them, ids in order; touching each other and the wall is allowed.
  auto arena =
      TestArena{.robots = 3, .ode = "start_poses = [0.1, -0.2, 1.5, 0.133, -0.2, -3, 0.4835, 0.4835, 0]"}.make();
  const hal::PoseFrame frame = frame_at(*arena, hal::LabTime{0});
  CHECK(frame.robots[0].pose.x_m == 0.1);
  CHECK(frame.robots[0].pose.y_m == -0.2);
  CHECK(frame.robots[0].pose.heading_rad == doctest::Approx(1.5));
  CHECK(frame.robots[1].pose.x_m == 0.133);
  CHECK(frame.robots[1].pose.heading_rad == doctest::Approx(-3));
  CHECK(frame.robots[2].pose.y_m == 0.4835);
}

TEST_CASE("impossible places") {
  // A wrong count, a place in the wall and overlapping robots are refused by name.
  const auto refusal = [](const char* poses) {
    try {
      TestArena{.robots = 2, .ode = std::string("start_poses = ") + poses}.make();
    } catch (const hal::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal("[0, 0, 0, 0.2, 0, 0]") == "accepted");
  CHECK(refusal("[0, 0, 0]").find("holds 1 place for 2 robots") != std::string::npos);
  CHECK(refusal("[0, 0, 0, 0.2]").find("three numbers for each robot") != std::string::npos);
  CHECK(refusal("[0, 0, 0, 0.2, 0.49, 0]").find("robot 1 at 0.2, 0.49, not wholly inside the walls") !=
        std::string::npos);
  CHECK(refusal("[0, 0, 0, 0.03, 0, 0]").find("robots 0 and 1 nearer than 0.033 m") != std::string::npos);
  CHECK(refusal("[0, 0, 0, nan, 0, 0]") != "accepted");
}

}  // namespace arkmesh::sim_ode
