#include "hal/bus/multicast_url.hpp"

#include <arpa/inet.h>

#include <cstdint>
#include <cstdlib>
#include <string>

namespace arkmesh::hal {

namespace {

// The text before `separator`, which is taken off `rest`, too.
std::string take_until(std::string_view& rest, char separator) {
  const auto end = rest.find(separator);
  const std::string text(rest.substr(0, end));
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  return text;
}

}  // namespace

MulticastUrl::MulticastUrl(std::string_view url) {
  url.remove_prefix(multicast_scheme.size());
  std::string network = take_until(url, '?');
  if (network.empty()) network = "239.255.76.67:7667";
  std::string_view port = network;
  const std::string address = take_until(port, ':');
  group.sin_family = AF_INET;
  inet_aton(address.c_str(), &group.sin_addr);
  group.sin_port = htons(static_cast<std::uint16_t>(std::strtol(std::string(port).c_str(), nullptr, 0)));
  while (!url.empty()) {
    const std::string argument = take_until(url, '&');
    std::string_view value = argument;
    const std::string key = take_until(value, '=');
    const int number = static_cast<int>(std::strtol(std::string(value).c_str(), nullptr, 0));
    if (key == "ttl") ttl = number;
    if (key == "recv_buf_size") receive_buffer_bytes = number;
  }
}

}  // namespace arkmesh::hal
