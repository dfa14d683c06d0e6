// What a gateway's process reads of a lab's file.
#pragma once

#include <map>
#include <string>

#include "gateway/config.hpp"
#include "hal/bus/bus_config.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::gateway {

// What the process needs of a lab's file; the other tables are the lab's.
struct ProcessConfig {
  std::string lab, experiment;
  hal::BusConfig bus;
  GatewayConfig gateway;
};

// Refuses keys of [gateway] that it does not know, and labs of the shared world that have no peer. Throws
// hal::ConfigError.
ProcessConfig read_process_config(const hal::Config& config);

// What a file says that counts at the start only, key by key.
std::map<std::string, std::string, std::less<>> fixed_keys(const hal::Config& config);

}  // namespace arkmesh::gateway
