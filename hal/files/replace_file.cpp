#include "hal/files/replace_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "hal/handle.hpp"

namespace arkmesh::hal {
namespace {

namespace fs = std::filesystem;

// Returns errno, as all here.
int write_part(const fs::path& part, std::string_view text, std::optional<mode_t> mode) {
  ::unlink(part.c_str());  // of a process that had our number
  const Handle handle(::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode.value_or(0644)));
  if (!handle || (mode && ::fchmod(handle.get(), *mode) != 0)) return errno;
  while (!text.empty()) {
    const ssize_t n = ::write(handle.get(), text.data(), text.size());
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
  return 0;
}

}  // namespace

fs::path part_of(const fs::path& file) {
  return fmt::format("{}.{}.part", file.string(), ::getpid());
}

int put_in_place(const fs::path& part, const fs::path& file) {
  const Handle handle(::open(part.c_str(), O_RDONLY | O_CLOEXEC));
  if (!handle || ::fsync(handle.get()) != 0 || ::rename(part.c_str(), file.c_str()) != 0) return errno;
  // the new name is on the disk with the folder; some file systems cannot sync one, and have no other way
  if (const Handle folder(::open((file.parent_path() / ".").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)); folder)
    ::fsync(folder.get());
  return 0;
}

int replace_file(const fs::path& file, std::string_view text, std::optional<mode_t> mode) {
  const fs::path part = part_of(file);
  int error = write_part(part, text, mode);
  if (error == 0) error = put_in_place(part, file);
  if (error != 0) ::unlink(part.c_str());
  return error;
}

void must_replace_file(const fs::path& file, std::string_view text, std::optional<mode_t> mode) {
  if (const int error = replace_file(file, text, mode); error != 0)
    throw std::runtime_error(fmt::format("{} cannot be written: {}", file.string(), std::strerror(error)));
}

}  // namespace arkmesh::hal
