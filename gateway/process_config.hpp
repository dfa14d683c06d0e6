// What a gateway process reads of a lab's file; the other tables are the lab's.
#pragma once

#include <string>

#include "gateway/config.hpp"
#include "hal/config.hpp"

namespace arkmesh::gateway {

struct ProcessConfig {
  std::string lab, bus_url;
  GatewayConfig gateway;
};

// Refuses keys of [gateway] that it does not know, and labs of the shared world that have no peer. Throws ConfigError.
ProcessConfig read_process_config(const hal::Config& config);

}  // namespace arkmesh::gateway
