// [bus] of a lab's file: its public bus.
#pragma once

#include <string>
#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::hal {

struct BusConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";  // LCM's port
  std::vector<std::string> hear;

  void fields(const Section& bus) {
    bus.field("url", url, {.help = "the lab's public bus; every lab on a machine needs a port of its own"});
    bus.field("hear", hear, {.help = "hosts whose messages count beside this machine's, by IPv4 address; with ttl=1"});
  }
  void check(const Section& bus) const;
};

}  // namespace arkmesh::hal
