// The page's files, which are part of the program.
#pragma once

#include <optional>
#include <string_view>

namespace arkmesh::view {

struct PageFile {
  std::string_view type, bytes;  // as HTTP says it; for as long as the program runs
};

// By the path of a request: "/" is index.html, "/page/..." what lies in view/page/, "/types.json" the types of
// messages.
std::optional<PageFile> page_file(std::string_view path);

}  // namespace arkmesh::view
