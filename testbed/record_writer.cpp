#include "testbed/record_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>

namespace arkmesh::testbed {

namespace fs = std::filesystem;

void RecordWriter::finish() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_.notify_all();
  thread_.join();
}

void RecordWriter::begin() {
  if (thread_.joinable()) return;
  std::error_code error;
  fs::create_directories(settings_.folder, error);
  if (error || !std::ofstream(settings_.folder / "looks.txt", std::ios::app))
    throw std::runtime_error(fmt::format("cannot record in {}: {}; choose another folder", settings_.folder.string(),
                                         error ? error.message() : "nothing can be written there"));
  thread_ = std::thread([this] { run(); });
}

void RecordWriter::line(const std::string& file, const std::string& text) {
  {
    const std::lock_guard lock(mutex_);
    if (lines_failed_ || held_bytes_ + text.size() > settings_.hold_bytes)
      return counters_.add("raw.not_recorded.lines");
    held_bytes_ += text.size();
    lines_.push_back({file, text});
  }
  work_.notify_all();
}

bool RecordWriter::picture(const fs::path& file, const cv::Mat& bgr, std::vector<std::uint8_t> jpeg) {
  Picture picture{file, bgr, std::move(jpeg)};
  const std::size_t bytes = picture.bytes();
  {
    std::unique_lock lock(mutex_);
    const auto fits = [&] { return held_bytes_ + bytes <= settings_.hold_bytes || pictures_.empty(); };
    if (settings_.patient && thread_.joinable()) room_.wait(lock, [&] { return disk_full_ || fits(); });
    if (disk_full_) return counters_.add("raw.not_recorded.disk_full"), false;
    if (!fits()) return counters_.add("raw.not_recorded.too_fast"), false;
    held_bytes_ += bytes;
    pictures_.push_back(std::move(picture));
  }
  work_.notify_all();
  return true;
}

RecordWriter::Written RecordWriter::written() const {
  const std::lock_guard lock(mutex_);
  return written_;
}

std::string RecordWriter::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

hal::Counters RecordWriter::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

// The thread: all lines that wait, then one picture, and again.
void RecordWriter::run() {
  for (;;) {
    std::deque<Line> lines;
    std::deque<Picture> picture;
    std::size_t bytes = 0;
    {
      std::unique_lock lock(mutex_);
      work_.wait(lock, [this] { return stopping_ || !lines_.empty() || !pictures_.empty(); });
      if (lines_.empty() && pictures_.empty()) return;
      lines.swap(lines_);
      for (const Line& line : lines) bytes += line.text.size();
      if (!pictures_.empty()) {
        bytes += pictures_.front().bytes();
        picture.push_back(std::move(pictures_.front()));
        pictures_.pop_front();
      }
    }
    write(lines);
    for (const Picture& each : picture) write(each);
    {
      const std::lock_guard lock(mutex_);
      held_bytes_ -= bytes;
    }
    room_.notify_all();
  }
}

void RecordWriter::write(const std::deque<Line>& lines) {
  if (lines.empty()) return;
  {
    const std::lock_guard lock(mutex_);
    if (lines_failed_) return counters_.add("raw.not_recorded.lines", lines.size());
  }
  for (const Line& line : lines) {
    auto file = std::ranges::find(files_, line.file, &std::pair<std::string, std::ofstream>::first);
    if (file == files_.end()) {
      files_.emplace_back(line.file, std::ofstream(settings_.folder / line.file, std::ios::app));
      file = std::prev(files_.end());
    }
    file->second << line.text << '\n';
  }
  // Behind a line that is cut no other one may follow.
  for (auto& [name, stream] : files_)
    if (!stream.flush()) {
      fail("raw.not_recorded.lines",
           fmt::format("cannot write more to {}, perhaps because the disk is full; the run continues without it",
                       (settings_.folder / name).string()),
           lines.size());
      const std::lock_guard lock(mutex_);
      lines_failed_ = true;
      return;
    }
}

void RecordWriter::write(const Picture& picture) {
  const fs::path file = settings_.folder / picture.file;
  std::error_code error;
  const fs::space_info space = fs::space(settings_.folder, error);
  if (!error && space.available < settings_.keep_free_bytes) {
    fail("raw.not_recorded.disk_full",
         fmt::format("the disk of {} has less than {} MB left: no more pictures are recorded, and the run continues",
                     settings_.folder.string(), settings_.keep_free_bytes >> 20));
    const std::lock_guard lock(mutex_);
    disk_full_ = true;
    return;
  }
  std::vector<std::uint8_t> png;
  try {
    if (picture.jpeg.empty()) cv::imencode(".png", picture.bgr, png);  // OpenCV's defaults are its fastest
  } catch (const cv::Exception&) {
    // said below: nothing was made
  }
  const std::vector<std::uint8_t>& bytes = picture.jpeg.empty() ? png : picture.jpeg;
  fs::create_directories(file.parent_path(), error);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (bytes.empty() || !out.flush()) {
    out.close();
    fs::remove(file, error);
    return fail(
        "raw.not_recorded.picture_failed",
        fmt::format("{} cannot be written, perhaps because the disk is full; the run continues", file.string()));
  }
  const std::lock_guard lock(mutex_);
  ++written_.pictures;
  written_.bytes += bytes.size();
}

// What went wrong first is what is said.
void RecordWriter::fail(const char* counter, const std::string& why, std::uint64_t times) {
  const std::lock_guard lock(mutex_);
  counters_.add(counter, times);
  if (error_.empty()) error_ = why;
}

}  // namespace arkmesh::testbed
