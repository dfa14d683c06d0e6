// What one check of `arkmesh doctor` found.
#pragma once

#include <string>

namespace arkmesh::hal {

struct Finding {
  std::string what;     // the thing looked at
  std::string problem;  // one sentence; empty when all is well
  std::string remedy;   // what to do, a command where there is one
};

}  // namespace arkmesh::hal
