// What names an experiment or a version: text that can be shown anywhere.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace arkmesh::hal {

inline constexpr std::size_t max_label = 63;

// 1 to 63 printable ASCII characters.
inline bool is_label(std::string_view text) {
  return !text.empty() && text.size() <= max_label &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace arkmesh::hal
