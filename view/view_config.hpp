// [view] of a lab's file: its page for browsers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/config.hpp"

namespace arkmesh::view {

struct ViewConfig {
  bool use = true;
  std::uint16_t port = 8800;
  std::string address = "127.0.0.1";
  std::vector<std::string> hosts;
  bool control = true;
  double per_s = 30;
  std::size_t viewers = 32;

  void fields(const hal::Section& view);
  void check(const hal::Section& view) const;
};

bool is_loopback(const std::string& address);

}  // namespace arkmesh::view
