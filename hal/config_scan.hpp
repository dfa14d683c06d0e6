// A first look at TOML text, before a parser that recurses and takes much for granted sees it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace arkmesh::hal {

struct ScanComplaint {
  unsigned line = 1;
  std::string sentence;
};

// Complains about keys with very many dots (each one is a table within a table) and about characters that may stand in
// texts and comments only. Judges nothing else.
std::optional<ScanComplaint> scan_toml(std::string_view text);

}  // namespace arkmesh::hal
