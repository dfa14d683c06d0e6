// How long a test goes on that repeats one thing many times.
#pragma once

#include <cstdlib>

namespace arkmesh::tests {

// Whether ARKMESH_THOROUGH is set, as each night: tests repeat as often as their words say; else a part of that.
inline bool thorough() {
  return std::getenv("ARKMESH_THOROUGH") != nullptr;
}

}  // namespace arkmesh::tests
