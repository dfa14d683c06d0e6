#include "recording/export/names.hpp"

#include <fmt/format.h>

namespace arkmesh::recording {

std::string safe_name(std::string_view name) {
  constexpr std::size_t most = 100;  // file systems allow 255 bytes, with what stands behind
  std::string out;
  for (const char c : name.substr(0, most)) {
    const bool is_plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
    out += is_plain ? c : '_';
  }
  if (out.find_first_not_of('.') == std::string::npos) out = "_";
  return out;
}

std::string Names::of(std::string_view name) {
  std::string above;
  while (true) {
    const std::size_t end = name.find('/');
    const bool is_last = end == std::string_view::npos;
    const std::string part = above + safe_name(name.substr(0, end));
    std::string out = part;
    for (int number = 2; files_.contains(out) || (is_last && folders_.contains(out)); ++number)
      out = fmt::format("{}_{}", part, number);
    (is_last ? files_ : folders_).insert(out);
    if (is_last) return out;
    above = out + '/';
    name.remove_prefix(end + 1);
  }
}

}  // namespace arkmesh::recording
