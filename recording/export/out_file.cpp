#include "recording/export/out_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "hal/files/replace_file.hpp"

namespace arkmesh::recording {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
  throw std::runtime_error(
      fmt::format("{} cannot be written: {}; choose another place with --out", file.string(), std::strerror(error)));
}

}  // namespace

void make_folder_of(const std::filesystem::path& file) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  if (error) fail(file, error.value());
}

OutFile::OutFile(const std::filesystem::path& file) : file_(file), part_(hal::part_of(file)) {
  make_folder_of(file);
  descriptor_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) fail(file_, errno);
}

OutFile::~OutFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(part_.c_str());
}

void OutFile::write_out() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t n = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(file_, errno);
    done += static_cast<std::size_t>(n);
  }
  written_ += buffer_.size();
  buffer_.clear();
}

void OutFile::finish() {
  write_out();
  if (const int error = hal::put_in_place(part_, file_); error != 0) fail(file_, error);
  ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace arkmesh::recording
