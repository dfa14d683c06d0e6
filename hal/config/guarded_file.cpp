#include "hal/config/guarded_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "hal/config/config.hpp"
#include "hal/files/replace_file.hpp"
#include "hal/handle.hpp"

namespace arkmesh::hal {

namespace fs = std::filesystem;

fs::path user_folder() {
  const char* const xdg = std::getenv("XDG_CONFIG_HOME");
  if (xdg && *xdg == '/') return fs::path(xdg) / "arkmesh";
  const char* const home = std::getenv("HOME");
  return home && *home == '/' ? fs::path(home) / ".config/arkmesh" : fs::path();
}

std::optional<std::string> read_guarded(const fs::path& file, bool is_secret) {
  const Handle handle(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  struct stat facts {};
  if (!handle && (errno == ENOENT || errno == ENOTDIR)) return {};
  if (!handle && (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == EIO))
    throw std::runtime_error(fmt::format("{} cannot be read now: {}", file.string(), std::strerror(errno)));
  if (!handle || ::fstat(handle.get(), &facts) != 0)
    throw ConfigError(fmt::format("{} cannot be read: {}", file.string(), std::strerror(errno)));
  if (!S_ISREG(facts.st_mode)) throw ConfigError(fmt::format("{} is not a file", file.string()));
  if (is_secret && facts.st_uid != ::geteuid())
    throw ConfigError(
        fmt::format("{} belongs to another user; a lab's key must belong to the user who runs it", file.string()));
  if (is_secret && (facts.st_mode & 077) != 0)
    throw ConfigError(fmt::format(
        "{} can be read or changed by other users (mode {:04o}); if you are sure that nobody did: chmod 600 {}",
        file.string(), facts.st_mode & 07777, file.string()));
  std::string text(max_guarded_bytes + 1, '\0');
  const ssize_t size = ::read(handle.get(), text.data(), text.size());
  if (size < 0) throw ConfigError(fmt::format("{} cannot be read: {}", file.string(), std::strerror(errno)));
  if (static_cast<std::size_t>(size) > max_guarded_bytes)
    throw ConfigError(
        fmt::format("{} is longer than {} bytes, too long for a certificate", file.string(), max_guarded_bytes));
  text.resize(static_cast<std::size_t>(size));
  return text;
}

void write_guarded(const fs::path& file, const std::string& text, mode_t mode) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  must_replace_file(file, text, mode);
}

}  // namespace arkmesh::hal
