// Follows texts and comments well enough for valid TOML. In invalid TOML it may lose the thread, but only behind the
// place where the parser stops.
#include "hal/config_scan.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace arkmesh::hal {

namespace {

constexpr int max_dots = 32;

// The end of the quoted text that begins at `at`: the index behind its last quote, or npos when it has none.
std::size_t end_of_text(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string three(3, quote);
  const bool multi_line = text.substr(at).starts_with(three);
  if (!multi_line && text.substr(at + 1).starts_with(quote)) return at + 2;  // empty
  for (std::size_t i = at + (multi_line ? 3 : 1); i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\')
      ++i;
    else if (!multi_line && text[i] == '\n')
      return std::string_view::npos;
    else if (!multi_line && text[i] == quote)
      return i + 1;
    else if (multi_line && text.substr(i).starts_with(three)) {
      // up to two quotes of the text itself may stand right before the three
      for (i += 3; i < text.size() && text[i] == quote; ++i) {
      }
      return i;
    }
  }
  return std::string_view::npos;
}

}  // namespace

std::optional<ScanComplaint> scan_toml(std::string_view text) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  unsigned line = 1;
  int dots = 0;  // in the key at hand
  for (std::size_t i = text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0; i < text.size();) {
    const char c = text[i];
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\'') {
      const std::size_t end = end_of_text(text, i);
      if (end == std::string_view::npos) return {};  // the parser says it better
      line += static_cast<unsigned>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                               text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      i = end;
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    if (byte >= 0x7f || (byte < 0x20 && c != '\t' && c != '\n' && c != '\r'))
      return ScanComplaint{line, "not valid TOML: a character that may stand in quotes only"};
    if (c == '.' && ++dots > max_dots)
      return ScanComplaint{line, fmt::format("a key with more than {} dots", max_dots)};
    if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) dots = 0;
    if (c == '\n') ++line;
    ++i;
  }
  return {};
}

}  // namespace arkmesh::hal
