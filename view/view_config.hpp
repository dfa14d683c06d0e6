// [view] of a lab's file: its page for browsers.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::view {

struct ViewConfig {
  bool use = true;
  std::uint16_t port = 8800;
  std::string address = "127.0.0.1";
  std::vector<std::string> hosts;
  bool control = true;
  double per_s = 30;
  std::size_t viewers = 32;
  std::string emulator;  // empty: none

  void fields(const hal::Section& view);
  void check(const hal::Section& view) const;
};

// "127.0.0.1:8092" or "[::1]:8092"; nothing when it is none of these.
std::optional<boost::asio::ip::tcp::endpoint> endpoint_of(const std::string& text);

bool is_loopback(const std::string& address);

}  // namespace arkmesh::view
