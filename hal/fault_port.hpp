// What can be done to an emulated testbed from outside, as hands and accidents do to a real one. An arena that offers
// it implements this beside Arena; who has an Arena finds out by dynamic_cast.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hal/types.hpp"

namespace arkmesh::hal {

class FaultPort {
 public:
  virtual ~FaultPort() = default;
  // A line as on the emulator's control port: "camera camera0 dark". Returns "ok", an answer, or "error: " and a
  // sentence.
  virtual std::string fault(std::string_view line) = 0;
  // The same of robot `id`, as poses name it: "kill".
  virtual std::string fault_of(RobotId id, std::string_view line) = 0;
  // A hand puts that robot at a place of the arena (metres from its centre); without a heading it keeps its own.
  // Returns as fault().
  virtual std::string put(RobotId id, double x_m, double y_m, std::optional<double> heading_rad) = 0;
};

}  // namespace arkmesh::hal
