// Which lab a file is of, and with whom it shares a world: lab.name, shared.labs, shared.owner. The lab, its gateway
// and `arkmesh explain` read them here, and so refuse the same in the same words.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::hal {

// In one shared world.
inline constexpr std::size_t max_labs = 64;

struct Participants {
  std::string lab;                // [a-z0-9_-]{1,15}
  std::vector<std::string> labs;  // ascending, this lab included; default: this lab alone
  std::string owner;              // one of them; default: the first

  void fields(const Section& root);
  void check(const Section& root);
};

}  // namespace arkmesh::hal
