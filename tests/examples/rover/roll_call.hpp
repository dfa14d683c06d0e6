// Who is who among the spots that the camera sees: calls one rover after the other to show its light, and follows those
// that have a name. Pure: speaks to nobody.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/types.hpp"
#include "tests/examples/rover/devices.hpp"

namespace arkmesh::examples::rover {

class RollCall {
 public:
  explicit RollCall(std::vector<hal::RobotId> robots) : robots_(std::move(robots)) {}

  // One picture. `shows`: the rover that says that its LED is lit; the only lit spot without a name is then that rover.
  // A rover that is not near the place where it was seen last loses its name and is called again.
  void look(std::span<const Spot> spots, std::optional<hal::RobotId> shows);
  // Who is seen in that picture, ascending.
  const std::vector<hal::Observation>& seen() const { return seen_; }
  // Those without a name, ascending; the first of them is the one to be asked next.
  std::vector<hal::RobotId> unnamed() const;

 private:
  std::vector<hal::RobotId> robots_;  // ascending
  std::vector<hal::Observation> seen_;
};

}  // namespace arkmesh::examples::rover
