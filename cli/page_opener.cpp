#include "cli/page_opener.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>

#include "hal/guarded_file.hpp"

namespace arkmesh::cli {
namespace {

// The shell leaves at once, so that nobody has to wait for the browser; false: it could not be started.
bool open_in_browser(const std::string& target) {
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  posix_spawn_file_actions_addopen(&quiet, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&quiet, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&quiet, 2, "/dev/null", O_WRONLY, 0);
  const char* const words[] = {"sh", "-c", "command -v xdg-open && { setsid xdg-open \"$0\" & }", target.c_str(),
                               nullptr};
  pid_t child = 0;
  int code = 1;
  if (::posix_spawn(&child, "/bin/sh", &quiet, nullptr, const_cast<char* const*>(words), environ) == 0)
    ::waitpid(child, &code, 0);
  posix_spawn_file_actions_destroy(&quiet);
  return code == 0;
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
                 "arkmesh: xdg-open, which --open needs, could not open a browser here; open that address yourself\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "arkmesh: --open: {}\n", error.what());
  }
}

}  // namespace arkmesh::cli
