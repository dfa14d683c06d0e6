// What makes of robots are, and set points of wheels as words.
#include <doctest/doctest.h>

#include "hal/arenas/silent_link.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/robot/set_point.hpp"
#include "hal/robot/thymio.hpp"

using namespace arkmesh::hal;

namespace {

RobotKind a_kilobot() {
  return kilobot::kind_of(kilobot::ark_layout, WholeMessages::to_each);
}

ArenaInfo arena_of(const RobotKind& kind) {
  ArenaInfo info{kind};
  info.robots = {1, 2};
  return info;
}

}  // namespace

TEST_CASE("robot kind: Kilobots and Thymios") {
  // Numbers of one make go together.
  const RobotKind thymio_kind = thymio(), kilobot_kind = a_kilobot();
  CHECK(thymio_kind.make != kilobot_kind.make);
  CHECK(thymio_kind.body_radius_m + thymio_kind.drive.axle_behind_m == doctest::Approx(0.08).epsilon(0.02));
  CHECK(thymio_target_per_mm_s * 1000 * thymio_kind.drive.speed_m_s == doctest::Approx(500));
  CHECK(kilobot_kind.words_per_s == doctest::Approx(54.5).epsilon(0.001));
  CHECK_FALSE(kilobot_kind.can_be_driven());
}

TEST_CASE("robot kind: set points") {
  // A set point goes through as a word of its own register, cut to what the robot can do; others are no set points.
  const RobotKind kind = thymio();
  for (const SetPoint& wheels : {SetPoint{0, 0}, SetPoint{200, -200}, SetPoint{-1, 199}}) {
    const ToRobot word = to_robot(2, wheels);
    CHECK(word.robot == 2);
    CHECK(word.value < 1u << 24);
    CHECK(set_point_in(kind, word) == wheels);
    CHECK_FALSE(set_point_in(a_kilobot(), word));
  }
  CHECK(set_point_in(kind, to_robot(2, SetPoint{100'000, -100'000})) == SetPoint{200, -200});
  CHECK_FALSE(set_point_in(kind, ToRobot{.robot = 2, .slot = 0, .value = 5}));
  CHECK_FALSE(set_point_in(kind, ToRobot{.robot = 2, .slot = set_point_slot, .kind = 1}));
}

TEST_CASE("robot kind: refused by name") {
  // A set point needs a known robot that can be driven; commands that a make does not know are refused by their name.
  const ArenaInfo thymios = arena_of(thymio()), kilobots = arena_of(a_kilobot());
  CHECK(refusal(thymios, to_robot(2, SetPoint{200, 200})) == nullptr);
  CHECK(refusal(thymios, to_robot(3, SetPoint{200, 200})) == std::string("to_robots.refused.unknown_robot"));
  CHECK(refusal(kilobots, to_robot(2, SetPoint{200, 200})) == std::string("to_robots.refused.value"));
  CHECK(refusal(thymios, FleetCommand{FleetCommand::Kind::sleep}) == std::string("fleet_command.refused.sleep"));
  CHECK(refusal(thymios, FleetCommand{FleetCommand::Kind::reset}) == nullptr);
}
