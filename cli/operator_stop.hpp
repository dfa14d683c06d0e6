// Ctrl-C, SIGTERM, or a terminal that is closed, as a wish that work ends in good order.
#pragma once

#include "hal/stop_request.hpp"

namespace arkmesh::cli {

// Listens from its making on; all of a process share one wish. Who wishes it a second time ends the process at once,
// which may be waiting for something.
class OperatorStop final : public hal::StopRequest {
 public:
  OperatorStop();
  bool stopped() override;
};

}  // namespace arkmesh::cli
