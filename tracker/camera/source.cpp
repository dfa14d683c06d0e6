#include "tracker/camera/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "hal/counted.hpp"
#include "hal/files/replace_file.hpp"
#include "hal/files/whole_file.hpp"
#include "tracker/camera/jpeg_stream.hpp"
#include "tracker/camera/lower_case.hpp"
#include "tracker/camera/picture_child.hpp"

namespace arkmesh::tracker {
namespace {

namespace fs = std::filesystem;

constexpr double folder_pictures_per_s = 10;
constexpr std::uintmax_t largest_picture_file = 1u << 30;

// frame9 before frame10. The names themselves decide where numbers do not.
bool natural_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  while (i < a.size() && j < b.size()) {
    if (!digit(a[i]) || !digit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    const auto number = [&](const std::string& text, std::size_t& at) {
      while (at < text.size() && text[at] == '0') ++at;
      const std::size_t begin = at;
      while (at < text.size() && digit(text[at])) ++at;
      return text.substr(begin, at - begin);
    };
    const std::string left = number(a, i), right = number(b, j);
    if (left != right) return std::tuple(left.size(), left) < std::tuple(right.size(), right);
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;
}

class PictureFiles final : public Recording {
 public:
  explicit PictureFiles(std::vector<fs::path> files) : files_(std::move(files)) {}
  std::optional<Picture> next() override {
    if (next_ == files_.size()) return {};
    Picture picture{.bgr = read_picture(files_[next_]),
                    .number = static_cast<std::uint32_t>(next_),
                    .name = files_[next_].filename().string()};
    picture.stamp = hal::LabTime(std::llround(static_cast<double>(next_) * 1e6 / folder_pictures_per_s));
    ++next_;
    return picture;
  }
  std::optional<std::uint32_t> pictures() const override { return static_cast<std::uint32_t>(files_.size()); }
  double pictures_per_s() const override { return folder_pictures_per_s; }
  bool rate_is_guess() const override { return files_.size() > 1; }

 private:
  std::vector<fs::path> files_;
  std::size_t next_ = 0;
};

class VideoFile final : public Recording {
 public:
  explicit VideoFile(const std::string& path) : path_(path), child_({.path = path, .shown = path, .live = false}) {
    const PictureChild::Event opened = child_.next(never);
    if (opened.record.kind != PictureRecord::Kind::opened) throw std::runtime_error(opened.error);
    guess_ = !(opened.record.pictures_per_s > 0.01 && opened.record.pictures_per_s < 10'000);
    if (!guess_) pictures_per_s_ = opened.record.pictures_per_s;
    if (opened.record.count > 0 && opened.record.count < 1'000'000'000)
      pictures_ = static_cast<std::uint32_t>(opened.record.count);
  }
  std::optional<Picture> next() override {
    if (damaged_ > 0) return damaged();
    PictureChild::Event event = child_.next(never);
    const PictureRecord& record = event.record;
    switch (record.kind) {
      case PictureRecord::Kind::jpeg:
      case PictureRecord::Kind::bgr:
        last_ = later_than_last(hal::LabTime(std::clamp<std::int64_t>(record.time_us, 0, longest_us)));
        return Picture{.bgr = std::move(event.bgr), .stamp = last_, .number = next_++, .name = name()};
      case PictureRecord::Kind::damaged:
        damaged_ = std::clamp<std::int64_t>(record.count, 1, 1'000'000);
        return damaged();
      case PictureRecord::Kind::ended:
        if (record.count > 0)
          end_with(fmt::format("{} announces {} that it does not contain: it is cut or damaged", path_,
                               hal::counted(static_cast<std::size_t>(record.count), "more picture")));
        return {};
      default:
        end_with(fmt::format("{}, behind {}", event.error, hal::counted(next_, "picture")));
        return {};
    }
  }
  std::optional<std::uint32_t> pictures() const override { return pictures_; }
  double pictures_per_s() const override { return pictures_per_s_; }
  bool rate_is_guess() const override { return guess_; }
  std::string error() const override { return error_; }

 private:
  static constexpr std::int64_t longest_us = 1'000'000'000'000'000;
  static bool never() { return false; }
  std::string name() const { return fmt::format("picture {} of {}", next_ - 1, path_); }
  void end_with(const std::string& why) {
    if (!std::exchange(has_ended_, true)) error_ += (error_.empty() ? "" : "; ") + why;
  }
  hal::LabTime later_than_last(hal::LabTime told) {
    if (!std::exchange(has_last_, true) || told > last_) return told;
    if (error_.empty())
      error_ = fmt::format(
          "the time stamps of {} go back or stand still at picture {}; times from there on assume {:g} a second", path_,
          next_, pictures_per_s_);
    return last_ + hal::LabTime(std::llround(1e6 / pictures_per_s_));
  }
  std::optional<Picture> damaged() {
    --damaged_;
    ++next_;
    return Picture{.bgr = {}, .stamp = last_, .number = next_ - 1, .name = name()};
  }

  std::string path_, error_;
  PictureChild child_;
  double pictures_per_s_ = 25;
  bool guess_ = false, has_last_ = false, has_ended_ = false;
  std::optional<std::uint32_t> pictures_;
  std::uint32_t next_ = 0;
  std::int64_t damaged_ = 0;  // pictures to be given as such
  hal::LabTime last_{0};
};

}  // namespace

SourceKind source_kind(const std::string& source) {
  const bool number = !source.empty() && source.size() <= 3 &&
                      std::all_of(source.begin(), source.end(), [](unsigned char c) { return std::isdigit(c); });
  if (number || source.starts_with("/dev/video")) return SourceKind::camera;
  const std::size_t colon = source.find("://");
  if (colon == std::string::npos || colon == 0 ||
      !std::all_of(source.begin(), source.begin() + static_cast<long>(colon),
                   [](unsigned char c) { return std::isalnum(c) || c == '+' || c == '-'; }))
    return SourceKind::recording;
  const std::string scheme = lower_case(source.substr(0, colon));
  for (const char* known : {"http", "https", "rtsp", "rtmp", "udp", "tcp"})
    if (scheme == known) return SourceKind::url;
  throw std::runtime_error(
      fmt::format("{}: cameras are found at http, https, rtsp, rtmp, udp or tcp, not at {}", source, scheme));
}

bool is_picture_name(const fs::path& file) {
  const std::string ending = lower_case(file.extension().string());
  for (const char* known : {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".ppm", ".pgm", ".webp"})
    if (ending == known) return true;
  return false;
}

std::vector<fs::path> pictures_of(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (is_picture_name(it->path()) && it->is_regular_file(error)) files.push_back(it->path());
  if (error)
    throw std::runtime_error(fmt::format("the folder {} cannot be read: {}", folder.string(), error.message()));
  if (files.empty())
    throw std::runtime_error(
        fmt::format("the folder {} holds no picture (png, jpg, bmp, tif, ppm, webp)", folder.string()));
  const auto before = [](const fs::path& a, const fs::path& b) {
    return natural_before(a.filename().string(), b.filename().string());
  };
  std::sort(files.begin(), files.end(), before);
  return files;
}

cv::Mat read_picture(const fs::path& file) {
  try {
    std::string bytes = hal::whole_file(file, largest_picture_file).value_or("");
    const cv::Mat row(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data());
    if (lacks_pixels({row.data, bytes.size()})) return {};  // OpenCV would make them up
    return cv::imdecode(row, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    return {};  // an absurd size, for example: as good as unreadable
  }
}

void write_picture(const fs::path& file, const cv::Mat& bgr) {
  std::vector<unsigned char> bytes;
  try {
    if (cv::imencode(file.extension().string(), bgr, bytes))
      return hal::must_replace_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const cv::Exception&) {
    // said below
  }
  throw std::runtime_error(fmt::format("{} cannot be written: give a name ending in .png", file.string()));
}

void finish_video(cv::VideoWriter& writer, const std::string& file, std::int64_t pictures) {
  writer.release();
  cv::VideoCapture written(file, cv::CAP_FFMPEG);
  cv::Mat last;
  if (written.isOpened() && written.set(cv::CAP_PROP_POS_FRAMES, static_cast<double>(pictures - 1)) &&
      std::llround(written.get(cv::CAP_PROP_POS_FRAMES)) == pictures - 1 && written.read(last))
    return;
  throw std::runtime_error(fmt::format("{} could not be written to the end; is the disk full?", file));
}

std::unique_ptr<Recording> open_recording(const std::string& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (!fs::exists(status))
    throw std::runtime_error(
        fmt::format("there is no {}: give a video, a picture, a folder of pictures, a camera's number or a URL", path));
  if (fs::is_directory(status)) return std::make_unique<PictureFiles>(pictures_of(path));
  if (is_picture_name(path)) return std::make_unique<PictureFiles>(std::vector<fs::path>{path});
  return std::make_unique<VideoFile>(path);
}

void quieten_libraries() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // AV_LOG_QUIET
}

}  // namespace arkmesh::tracker
