#include "view/page_files.hpp"

#include <algorithm>
#include <span>

#include "view/embedded.hpp"

namespace arkmesh::view {
namespace {

struct Ending {
  std::string_view ending, type;
};

constexpr Ending endings[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".md", "text/plain; charset=utf-8"},
    {".txt", "text/plain; charset=utf-8"},
};

std::string_view type_of(std::string_view path) {
  for (const Ending& row : endings)
    if (path.ends_with(row.ending)) return row.type;
  return "application/octet-stream";
}

}  // namespace

std::optional<PageFile> page_file(std::string_view path) {
  if (path == "/") path = "/page/index.html";
  const auto files = embedded_files();
  const auto found = std::ranges::find(files, path, &EmbeddedFile::path);
  if (found == files.end()) return std::nullopt;
  return PageFile{type_of(path), found->bytes()};
}

}  // namespace arkmesh::view
