// Plain write(2), because stdio does not say how much of its buffer reached the file before the disk was full.
#include "hal/record/record_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace arkmesh::hal {

RecordFile::RecordFile(const std::filesystem::path& file, bool compress)
    : descriptor_(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), file.string());
  if (compress) packer_.emplace();
}

RecordFile::~RecordFile() {
  close(descriptor_);
}

RecordFile::Written RecordFile::write_out() {
  const std::span<const std::byte> bytes = packer_ ? packer_->pack(buffer_) : buffer_;
  std::size_t done = 0;
  int error = 0;
  while (done < bytes.size() && error == 0) {
    const ssize_t n = write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (n >= 0)
      done += static_cast<std::size_t>(n);
    else if (errno != EINTR)
      error = errno;
  }
  Written out{error, 0};
  if (error != 0) {
    // of a frame, half is nothing
    const auto first_lost = std::upper_bound(ends_.begin(), ends_.end(), packer_ ? 0 : done);
    out.lost = static_cast<std::uint64_t>(ends_.end() - first_lost);
    done = first_lost == ends_.begin() ? 0 : *(first_lost - 1);
    // /dev/full and the like cannot be cut
    [[maybe_unused]] const int cut = ftruncate(descriptor_, static_cast<off_t>(size_ + done));
    lseek(descriptor_, 0, SEEK_END);
  }
  size_ += done;
  buffer_.clear();
  ends_.clear();
  return out;
}

}  // namespace arkmesh::hal
