// What all robots on an arena should hear over and over until the next question: a type and nine bytes, as every
// platform's broadcast (hal::FleetCommand) carries them.
#pragma once

#include <array>
#include <cstdint>

namespace arkmesh::tracker {

struct Question {
  std::array<std::uint8_t, 9> data{};
  std::uint8_t type = 0;  // 0..127
  bool operator==(const Question&) const = default;
};

}  // namespace arkmesh::tracker
