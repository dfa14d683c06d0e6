// How many of something, for messages: "1 robot", "3 robots".
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <string>
#include <string_view>

namespace arkmesh::hal {

// One is called `one`; several are called `many`, or, when that is empty, `one` with an s.
std::string counted(std::integral auto n, std::string_view one, std::string_view many = {}) {
  if (n == 1) return fmt::format("1 {}", one);
  return many.empty() ? fmt::format("{} {}s", n, one) : fmt::format("{} {}", n, many);
}

}  // namespace arkmesh::hal
