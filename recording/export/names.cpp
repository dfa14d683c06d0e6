#include "recording/export/names.hpp"

namespace arkmesh::recording {

std::string safe_name(std::string_view name) {
  std::string out;
  for (const char c : name) {
    const bool is_plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
    out += is_plain ? c : '_';
  }
  if (out.find_first_not_of('.') == std::string::npos) out = "_";
  return out;
}

std::string safe_path(std::string_view name) {
  std::string out;
  while (true) {
    const std::size_t end = name.find('/');
    out += safe_name(name.substr(0, end));
    if (end == std::string_view::npos) return out;
    out += '/';
    name.remove_prefix(end + 1);
  }
}

}  // namespace arkmesh::recording
