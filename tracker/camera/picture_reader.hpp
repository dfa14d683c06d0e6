// Reads a video file or a stream by FFmpeg's libraries: pictures with their own times, JPEG ones as they came, others
// decoded. Whatever FFmpeg does with bytes from outside may end or hang a process, so picture_child runs this in one of
// its own. No OpenCV here: a copy of a process has none of its threads.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace arkmesh::tracker {

inline constexpr std::int64_t max_picture_pixels = 128ll << 20;  // no camera has more

// What a reader hands on, followed by `bytes` of its own: a sentence, a JPEG, or rows of 8-bit BGR without gaps.
struct PictureRecord {
  enum class Kind : std::uint32_t {
    opened,   // rate and count are known
    jpeg,     // one picture
    bgr,      // likewise
    damaged,  // `count` pictures could not be decoded, and are left out
    ended,    // the source has no more; `count` came short of what it told
    failed,   // it cannot be read, or any further: a sentence
  };
  Kind kind = Kind::failed;
  std::int32_t width_px = 0, height_px = 0;
  std::int32_t quarter_turns = 0;  // clockwise, to be seen upright
  std::int64_t time_us = 0;        // of a file: since its first picture; of a stream: arrival, by the steady clock
  std::int64_t count = 0;          // opened: how many there should be; 0: nobody knows
  double pictures_per_s = 0;       // 0: nobody knows
  std::uint64_t bytes = 0;
};
// False: nobody wants more.
using TakePicture = std::function<bool(const PictureRecord& record, std::span<const std::uint8_t> bytes)>;

struct PictureSource {
  std::string path;   // a file's, or a URL
  std::string shown;  // as sentences call it
  bool live = false;  // a URL: what does not answer within 4 s, or gives nothing for 3 s, fails
  std::chrono::milliseconds patience{60'000};  // with a child that reads it and gives nothing: then it hangs
};

// Until the source ends or nobody wants more.
void read_pictures(const PictureSource& source, const TakePicture& take);

}  // namespace arkmesh::tracker
