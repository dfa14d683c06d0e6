// Where pictures come from. Recordings (a video file, a folder of pictures, one picture) give every picture in turn;
// live cameras are live_camera's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hal/types.hpp"

namespace cv {
class VideoWriter;
}

namespace arkmesh::tracker {

struct Picture {
  cv::Mat bgr;               // 8 bit; empty: it is damaged or no picture
  hal::LabTime stamp{0};     // since the first picture
  std::uint32_t number = 0;  // from 0
  std::string name;          // the file, where each picture is one; else its number in words
};

class Recording {
 public:
  virtual ~Recording() = default;
  // Nothing after the last.
  virtual std::optional<Picture> next() = 0;
  // How many there are, as far as is known beforehand.
  virtual std::optional<std::uint32_t> pictures() const = 0;
  virtual double pictures_per_s() const = 0;
  // Nothing tells when its pictures were taken: that many a second is a guess.
  virtual bool rate_is_guess() const = 0;
  // After the last: why that is not the end that the source tells of, one sentence; else empty.
  virtual std::string error() const { return {}; }
};

enum class SourceKind { camera, url, recording };

// A camera's number or /dev/video..., a URL, or a path. Looks at the spelling only. Throws std::runtime_error with one
// sentence for a URL of a kind that no camera speaks.
SourceKind source_kind(const std::string& source);

// Whether a file's name ends as pictures' names do.
bool is_picture_name(const std::filesystem::path& file);
// The pictures of a folder by name, numbers in names as numbers. Throws std::runtime_error with one sentence when there
// are none.
std::vector<std::filesystem::path> pictures_of(const std::filesystem::path& folder);
// 8-bit BGR; empty when the file is damaged or no picture.
cv::Mat read_picture(const std::filesystem::path& file);
// What is said of what gives no pixels.
inline constexpr const char* no_picture = "is damaged or not a picture (JPEG with arithmetic coding is not supported)";
// Throws std::runtime_error with one sentence.
void write_picture(const std::filesystem::path& file, const cv::Mat& bgr);
// Completes a video of so many pictures and looks whether the last one is in it: OpenCV does not say that the disk was
// full. Throws std::runtime_error with one sentence.
void finish_video(cv::VideoWriter& writer, const std::string& file, std::int64_t pictures);

// A video file, a folder (its pictures by name, numbers in names as numbers, ten a second) or one picture. Throws
// std::runtime_error with one sentence: not there, empty, no pictures in it, not readable.
std::unique_ptr<Recording> open_recording(const std::string& path);

// The messages of OpenCV and FFmpeg about cameras and files are ours to give, in one sentence each. Call before threads
// begin.
void quieten_libraries();

}  // namespace arkmesh::tracker
