#include "cli/page_opener.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "hal/child_process.hpp"
#include "hal/config/guarded_file.hpp"

namespace arkmesh::cli {
namespace {

// The shell leaves at once, so that nobody has to wait for the browser; false: it could not be started.
bool open_in_browser(const std::string& target) {
  const char* const words = "command -v xdg-open && { setsid xdg-open \"$0\" & } >/dev/null 2>&1";
  return hal::ChildProcess({.command = {"/bin/sh", "-c", words, target}, .own_group = false}).wait().code == 0;
}

}  // namespace

std::string page_words(const std::string& url) {
  return fmt::format("see it at {}", url);
}

void show_page(const std::string& url, const std::filesystem::path& directory, bool open) {
  fmt::print(stderr, "{}\n", page_words(url));
  if (!open) return;
  try {
    std::string target = url;
    if (url.find('#') != std::string::npos) {
      const std::filesystem::path file = std::filesystem::absolute(directory / "page.html");
      hal::write_guarded(
          file,
          fmt::format("<!DOCTYPE html><title>arkmesh</title><meta name=\"referrer\" content=\"no-referrer\">"
                      "<meta http-equiv=\"refresh\" content=\"0; url={0}\"><a href=\"{0}\">{0}</a>\n",
                      url),
          hal::secret_mode);
      target = file.string();
    }
    if (!open_in_browser(target))
      fmt::print(stderr,
                 "arkmesh: --open could not start a browser here (xdg-open failed); open that address yourself\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "arkmesh: --open: {}\n", error.what());
  }
}

}  // namespace arkmesh::cli
