// What can be done to an emulated testbed from outside, as hands and accidents do to a real one. An arena that offers
// it implements this beside Arena; who has an Arena finds out by dynamic_cast.
#pragma once

#include <string>
#include <string_view>

namespace arkmesh::hal {

class FaultPort {
 public:
  virtual ~FaultPort() = default;
  // A line as on the emulator's control port: "camera camera0 dark", "robot id:7 kill". Returns "ok", an answer, or
  // "error: " and a sentence.
  virtual std::string fault(std::string_view line) = 0;
};

}  // namespace arkmesh::hal
