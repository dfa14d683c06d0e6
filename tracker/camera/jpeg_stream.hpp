// JPEG pictures out of a stream of bytes, whatever stands between them: heads of a multipart stream, padding, damage.
// Pure: no devices, no clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace arkmesh::tracker {

class JpegStream {
 public:
  static constexpr std::size_t max_bytes = 64u << 20;  // of one picture; one that is longer is damaged

  void add(std::span<const std::uint8_t> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  // The next picture from its first marker to its last, both there; nothing before more bytes are added.
  std::optional<std::vector<std::uint8_t>> next();
  // What was added ends here: a picture that is not whole is none.
  void end();
  // Pictures that were begun and not ended, or in whose place something else came. Counts anew.
  std::size_t take_damaged() { return std::exchange(damaged_, 0); }

 private:
  enum class Step : std::uint8_t { more, picture, damaged };
  Step walk();
  void drop(std::size_t bytes);

  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;       // 0: between pictures; else so far the picture at the front has been walked
  bool in_scan_ = false;     // there: coded pixels, not a marker
  std::size_t between_ = 0;  // bytes since the last picture
  std::size_t damaged_ = 0;
};

// 8-bit BGR as the camera's pixels lie, without regard to a note of how it was held; empty: some pixels are missing or
// damaged, arithmetic coding hides whether they are, or there are more than any camera has.
cv::Mat decode_jpeg(std::span<const std::uint8_t> jpeg);
// True of a JPEG of which some pixels are missing or damaged, or may be; false of whatever else a file holds.
bool lacks_pixels(std::span<const std::uint8_t> file);

}  // namespace arkmesh::tracker
