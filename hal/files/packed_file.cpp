#include "hal/files/packed_file.hpp"

#include <unistd.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <cerrno>
#include <new>

namespace arkmesh::hal {
namespace {

// A recorder's buffer and the longest message of a log behind it.
constexpr std::size_t max_frame_bytes = 65 << 20;
constexpr std::size_t look_ahead_bytes = 1 << 20;
constexpr std::size_t max_header_bytes = 18;  // of a frame (ZSTD_FRAMEHEADERSIZE_MAX)

}  // namespace

void FramePacker::Free::operator()(ZSTD_CCtx_s* context) const {
  ZSTD_freeCCtx(context);
}

FramePacker::FramePacker() : context_(ZSTD_createCCtx()) {
  if (!context_ || ZSTD_isError(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1))) throw std::bad_alloc();
}

std::span<const std::byte> FramePacker::pack(std::span<const std::byte> bytes) {
  if (bytes.empty()) return {};
  frame_.resize(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress2(context_.get(), frame_.data(), frame_.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size)) throw std::bad_alloc();  // with that much room, nothing else can fail
  return std::span(frame_).first(size);
}

std::size_t read_file_at(int descriptor, std::uint64_t offset, std::span<std::byte> to) {
  std::size_t done = 0;
  while (done < to.size()) {
    const ssize_t n = ::pread(descriptor, to.data() + done, to.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

bool PackedFile::is_one(std::span<const std::byte> begin) {
  return begin.size() >= 4 &&
         boost::endian::load_little_u32(reinterpret_cast<const unsigned char*>(begin.data())) == ZSTD_MAGICNUMBER;
}

void PackedFile::look_again(std::uint64_t file_bytes) {
  file_bytes_ = std::max(file_bytes, place_);
  std::vector<std::byte> ahead;
  std::size_t used = 0;
  for (;;) {
    const auto left = std::span<const std::byte>(ahead).subspan(used);
    const unsigned long long bytes = ZSTD_getFrameContentSize(left.data(), left.size());
    const bool is_too_large = bytes != ZSTD_CONTENTSIZE_ERROR && bytes > max_frame_bytes;
    is_foreign_ = is_too_large && frames_.empty();
    if (is_foreign_) return;
    const std::size_t packed_bytes = ZSTD_findFrameCompressedSize(left.data(), left.size());
    if (!is_too_large && !ZSTD_isError(packed_bytes)) {
      if (bytes > 0) frames_.push_back({place_, packed_bytes, size_, static_cast<std::size_t>(bytes)});
      size_ += bytes;
      place_ += packed_bytes;
      used += packed_bytes;
      continue;
    }
    // The frame goes on behind what is in memory, or is cut, or damaged.
    const std::size_t known = left.size();
    std::uint64_t wanted = std::min<std::uint64_t>(unread_bytes(), std::max(look_ahead_bytes, 2 * known));
    if (is_too_large || ZSTD_getErrorCode(packed_bytes) != ZSTD_error_srcSize_wrong || wanted <= known ||
        known > 2 * max_frame_bytes) {
      const std::uint64_t next = next_frame();
      if (next == 0) return;
      skipped_ += next - place_;
      ++gaps_;
      place_ = next;
      wanted = std::min<std::uint64_t>(unread_bytes(), look_ahead_bytes);
    }
    ahead.resize(static_cast<std::size_t>(wanted));
    ahead.resize(read_file_at(descriptor_, place_, ahead));
    used = 0;
    if (ahead.size() < wanted) return;
  }
}

std::uint64_t PackedFile::next_frame() const {
  std::vector<std::byte> bytes(look_ahead_bytes);
  for (std::uint64_t from = place_ + 1; from < file_bytes_; from += look_ahead_bytes - max_header_bytes) {
    bytes.resize(read_file_at(descriptor_, from, bytes));
    for (std::size_t i = 0; i + max_header_bytes <= bytes.size(); ++i) {
      const auto rest = std::span<const std::byte>(bytes).subspan(i);
      if (!is_one(rest)) continue;
      const unsigned long long content = ZSTD_getFrameContentSize(rest.data(), rest.size());
      if (content > 0 && content <= max_frame_bytes) return from + i;
    }
    if (bytes.size() < look_ahead_bytes) break;
  }
  return 0;
}

std::span<const std::byte> PackedFile::unpacked(std::size_t frame) {
  if (frame == in_memory_) return bytes_;
  in_memory_ = frame;
  packed_.resize(frames_[frame].packed_bytes);
  bytes_.resize(frames_[frame].bytes);
  if (read_file_at(descriptor_, frames_[frame].place, packed_) < packed_.size() ||
      ZSTD_decompress(bytes_.data(), bytes_.size(), packed_.data(), packed_.size()) != bytes_.size())
    std::ranges::fill(bytes_, std::byte{0});
  return bytes_;
}

std::size_t PackedFile::read(std::uint64_t offset, std::span<std::byte> to) {
  std::size_t done = 0;
  while (done < to.size() && offset + done < size_) {
    const auto after = std::ranges::upper_bound(frames_, offset + done, {}, &Frame::begin);
    const auto frame = static_cast<std::size_t>(after - frames_.begin()) - 1;
    const auto bytes = unpacked(frame);
    const auto rest = bytes.subspan(static_cast<std::size_t>(offset + done - frames_[frame].begin));
    const std::size_t n = std::min(rest.size(), to.size() - done);
    std::ranges::copy(rest.first(n), to.begin() + static_cast<std::ptrdiff_t>(done));
    done += n;
  }
  return done;
}

}  // namespace arkmesh::hal
