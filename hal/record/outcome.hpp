// What came of a run, as its result.json says in one word (hal/record/result_file.hpp reads and writes it).
#pragma once

#include <cstdint>

namespace arkmesh::hal {

enum class Outcome : std::uint8_t {
  running,
  finished,
  stopped,  // by the operator
  failed,
  killed,  // its process was gone without a word; the next start beside it says so
};

}  // namespace arkmesh::hal
