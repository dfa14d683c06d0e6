// What the build puts into the program: CMakeLists.txt writes the source of embedded_files().
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace arkmesh::view {

struct EmbeddedFile {
  std::string_view path;  // of a request
  const char *begin, *end;
  std::string_view bytes() const { return {begin, static_cast<std::size_t>(end - begin)}; }
};

std::span<const EmbeddedFile> embedded_files();

}  // namespace arkmesh::view
