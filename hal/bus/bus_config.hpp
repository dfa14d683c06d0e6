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
    bus.field("url", url, {.help = "the lab's public LCM bus; each lab on a machine needs its own port"});
    bus.field("hear", hear,
              {.help = "IPv4 addresses of further hosts whose messages are accepted; needs ttl=1 in bus.url"});
  }
  void check(const Section& bus) const;
};

}  // namespace arkmesh::hal
