// Files of zstd frames, one after another, each of whole records: what a recorder writes with `recorder.compress`, and
// what `zstd -d` unpacks. Read at any place without unpacking what comes before; frames may be cut, damaged or foreign.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

struct ZSTD_CCtx_s;

namespace arkmesh::hal {

class FramePacker {
 public:
  // Throws std::bad_alloc, as pack() does.
  FramePacker();
  // A frame with a checksum that tells how long it is unpacked; valid until the next call. Of no bytes: nothing.
  std::span<const std::byte> pack(std::span<const std::byte> bytes);

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
  std::vector<std::byte> frame_;
};

// Fewer bytes than wanted at the file's end.
std::size_t read_file_at(int descriptor, std::uint64_t offset, std::span<std::byte> to);

class PackedFile {
 public:
  // Whether a file that begins with these bytes is one.
  static bool is_one(std::span<const std::byte> begin);
  // `descriptor`: of the file; the caller closes it, later.
  explicit PackedFile(int descriptor) : descriptor_(descriptor) {}

  // Finds the whole frames in the file's first `file_bytes`.
  void look_again(std::uint64_t file_bytes);
  // Of these frames, unpacked.
  std::uint64_t size() const { return size_; }
  // Of the file behind them.
  std::uint64_t unread_bytes() const { return file_bytes_ - place_; }
  // Of frames that were damaged so that they could not be passed, and at how many places.
  std::uint64_t skipped_bytes() const { return skipped_; }
  std::uint64_t gaps() const { return gaps_; }
  // The first frame is larger than any recorder's, or does not tell its size: nothing is read.
  bool is_foreign() const { return is_foreign_; }
  // Unpacked bytes from an unpacked offset on: fewer than wanted at the end; zeros where a frame is damaged.
  std::size_t read(std::uint64_t offset, std::span<std::byte> to);

 private:
  struct Frame {
    std::uint64_t place;       // in the file
    std::size_t packed_bytes;  // there
    std::uint64_t begin;       // unpacked
    std::size_t bytes;         // unpacked
  };
  // Where the next frame behind place_ begins; 0 when there is none.
  std::uint64_t next_frame() const;
  // Zeros when it is damaged.
  std::span<const std::byte> unpacked(std::size_t frame);

  int descriptor_;
  std::vector<Frame> frames_;
  std::uint64_t size_ = 0, place_ = 0, file_bytes_ = 0, skipped_ = 0, gaps_ = 0;
  bool is_foreign_ = false;
  std::size_t in_memory_ = SIZE_MAX;  // the frame whose bytes are here
  std::vector<std::byte> bytes_, packed_;
};

}  // namespace arkmesh::hal
