#include "hal/robot/thymio.hpp"

namespace arkmesh::hal {

RobotKind thymio() {
  using Command = FleetCommand::Kind;
  return {
      .make = "thymio",
      // 110 x 112 mm, rounded in front: taken for a disc as wide. Its corners at the back reach beyond
      .body_radius_m = 0.056,
      .height_m = 0.053,  // the top, which carries the marker. Makers' drawing, rounded
      .drive = {.way = RobotDrive::Way::differential,
                .speed_m_s = 0.2,
                .wheels_apart_m = 0.094,
                .axle_behind_m = 0.025},  // the body reaches 8 cm ahead of the axle, 3 cm behind it
      .seen_by = RobotKind::Seen::marker,
      .max_robot = 0xFFFF,
      .values = 1 << 16,  // its variables
      .words_per_s = 100,
      .commands = {Command::run, Command::pause, Command::reset},
      .says = {"prox.horizontal.0", "prox.horizontal.1", "prox.horizontal.2", "prox.horizontal.3", "prox.horizontal.4",
               "prox.horizontal.5", "prox.horizontal.6"},
  };
}

}  // namespace arkmesh::hal
