// A file that grows by whole records and never keeps half of one, also when the disk runs full in the middle of a
// write. On wish in zstd frames, one of each write.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "hal/files/packed_file.hpp"

namespace arkmesh::hal {

class RecordFile {
 public:
  // Creates the file, or empties it. `compress`: it is a PackedFile. Throws std::system_error.
  explicit RecordFile(const std::filesystem::path& file, bool compress = false);
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  // A record is what is appended between two calls of end_record(). Kept in memory until write_out().
  void append(std::span<const std::byte> bytes) { buffer_.insert(buffer_.end(), bytes.begin(), bytes.end()); }
  void end_record() { ends_.push_back(buffer_.size()); }
  std::size_t waiting_bytes() const { return buffer_.size(); }

  struct Written {
    int error = 0;           // errno of the write that failed
    std::uint64_t lost = 0;  // records that did not reach the file
  };
  // Hands the file system everything. When that fails the file is cut after its last whole record (or frame) and the
  // rest is forgotten.
  Written write_out();

 private:
  int descriptor_;
  std::optional<FramePacker> packer_;  // when it compresses
  std::uint64_t size_ = 0;             // of the file, all whole records
  std::vector<std::byte> buffer_;
  std::vector<std::size_t> ends_;  // of the records in buffer_
};

}  // namespace arkmesh::hal
