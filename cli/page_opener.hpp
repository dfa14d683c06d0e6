// Tells people where a page is, and opens it in their browser.
#pragma once

#include <filesystem>
#include <string>

namespace arkmesh::cli {

// What is said of a page.
std::string page_words(const std::string& url);

// Prints the URL to stderr. With `open` the desktop's browser opens it; a URL with a token by way of page.html in
// `directory`, which only this user can read, because anybody sees the arguments of programs. What goes wrong is said
// and counts for nothing.
void show_page(const std::string& url, const std::filesystem::path& directory, bool open);

}  // namespace arkmesh::cli
