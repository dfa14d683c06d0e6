// A file that an export writes: in large pieces, and under its name only when it is whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace arkmesh::recording {

class OutFile {
 public:
  // Writes FILE.PROCESS.part; makes the folders above. Throws std::runtime_error with one sentence, as all here, when
  // the disk refuses.
  explicit OutFile(const std::filesystem::path& file);
  // Without finish() the part is removed.
  ~OutFile();
  OutFile(const OutFile&) = delete;
  OutFile& operator=(const OutFile&) = delete;

  void write(std::string_view text) {
    buffer_.append(text);
    if (buffer_.size() >= buffer_bytes) write_out();
  }
  // What is appended here is written in time when room() is called now and then.
  std::string& buffer() { return buffer_; }
  void room() {
    if (buffer_.size() >= buffer_bytes) write_out();
  }
  std::uint64_t size() const { return written_ + buffer_.size(); }
  // Writes what is still to be written.
  void flush() { write_out(); }
  // Gives the file its name.
  void finish();

 private:
  static constexpr std::size_t buffer_bytes = 1 << 20;
  void write_out();

  std::filesystem::path file_, part_;
  int descriptor_ = -1;
  std::uint64_t written_ = 0;
  std::string buffer_;
};

// Makes the folders above. Throws as OutFile.
void make_folder_of(const std::filesystem::path& file);

}  // namespace arkmesh::recording
