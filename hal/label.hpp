// Text that can be shown anywhere: what names an experiment or a version, and what others say.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace arkmesh::hal {

inline constexpr std::size_t max_label = 63;

inline bool is_printable(char c) {
  return c >= ' ' && c <= '~';
}

// 1 to 63 printable ASCII characters.
inline bool is_label(std::string_view text) {
  return !text.empty() && text.size() <= max_label && std::all_of(text.begin(), text.end(), is_printable);
}

// At most `longest` bytes of another's text, for terminals and files: what is not printable ASCII is '?'.
inline std::string printable(std::string_view text, std::size_t longest) {
  std::string out(text.substr(0, longest));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return !is_printable(c); }, '?');
  return out;
}

}  // namespace arkmesh::hal
