// What an LCM URL says about a network bus, read as LCM reads it:
// "udpm://239.255.76.67:7701?ttl=0&recv_buf_size=4194304".
#pragma once

#include <netinet/in.h>

#include <string_view>

namespace arkmesh::hal {

inline constexpr std::string_view multicast_scheme = "udpm://";

struct MulticastUrl {
  sockaddr_in group{};  // address and port
  int ttl = 0;          // 0: nothing leaves this machine
  int receive_buffer_bytes = 4 << 20;

  // `url` begins with the scheme; LCM judges the rest.
  explicit MulticastUrl(std::string_view url);
};

}  // namespace arkmesh::hal
