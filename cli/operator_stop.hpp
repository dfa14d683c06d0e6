// Ctrl-C, SIGTERM, or a terminal that is closed, as a wish that work ends in good order; and SIGUSR1, by which `arkmesh
// up` ends labs because of another one.
#pragma once

#include <csignal>

#include "hal/stop_request.hpp"

namespace arkmesh::cli {

inline constexpr int group_failed_signal = SIGUSR1;

// Listens from its making on; all of a process share one wish. Who wishes it a second time ends the process at once,
// which may be waiting for something.
class OperatorStop final : public hal::StopRequest {
 public:
  OperatorStop();
  bool stopped() override;
  const char* failure() override;
};

}  // namespace arkmesh::cli
