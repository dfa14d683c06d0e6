#include "tracker/camera/picture_child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <opencv2/core.hpp>
#include <utility>

#include "tracker/camera/jpeg_stream.hpp"

namespace arkmesh::tracker {
namespace {

using namespace std::chrono_literals;
using Kind = PictureRecord::Kind;

constexpr std::chrono::milliseconds asks_every = 100ms;
constexpr int pipe_bytes = 1 << 20;  // so that a picture is few turns
constexpr std::uint64_t largest_picture_bytes = 3ull * max_picture_pixels;
constexpr int nobody_reads = 3;

bool write_all(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

// In the child: nothing of the process that it is a copy of is its business, least of all ports.
int read_to_output(const PictureSource& source) {
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  ::fcntl(STDOUT_FILENO, F_SETPIPE_SZ, pipe_bytes);
  bool read = true;
  read_pictures(source, [&](const PictureRecord& record, std::span<const std::uint8_t> bytes) {
    read = write_all({reinterpret_cast<const std::uint8_t*>(&record), sizeof record}) && write_all(bytes);
    return read;
  });
  return read ? 0 : nobody_reads;
}

}  // namespace

PictureChild::PictureChild(PictureSource source)
    : source_(std::move(source)),
      child_({.function =
                  [this] {
                    try {
                      return read_to_output(source_);
                    } catch (...) {
                      return 1;  // out of memory; its parent sees that it ended too early
                    }
                  },
              .keeps_errors = false}) {}

PictureChild::Event PictureChild::failed(std::string error) const {
  Event event;
  event.error = std::move(error);
  return event;
}

// False: it ended, hangs, or nobody wants more.
bool PictureChild::read(void* to, std::size_t bytes, const std::function<bool()>& stop) {
  auto* at = static_cast<std::uint8_t*>(to);
  const auto limit = std::chrono::steady_clock::now() + source_.patience;
  while (bytes > 0) {
    const ssize_t n = ::read(child_.output(), at, bytes);
    if (n > 0) at += n, bytes -= static_cast<std::size_t>(n);
    if (n > 0 || (n < 0 && errno == EINTR)) continue;
    silent_ = std::chrono::steady_clock::now() > limit;
    if (n == 0 || errno != EAGAIN || silent_ || stop()) return false;
    pollfd ready{child_.output(), POLLIN, 0};
    ::poll(&ready, 1, static_cast<int>(asks_every.count()));
  }
  return true;
}

PictureChild::Event PictureChild::next(const std::function<bool()>& stop) {
  Event event;
  PictureRecord& record = event.record;
  const auto broken = [&] {
    if (silent_) return failed(fmt::format("reading {} hung and was abandoned", source_.shown));
    if (stop()) return failed("");
    return failed(fmt::format("the decoder failed while reading {}; a damaged picture can cause that", source_.shown));
  };
  if (!read(&record, sizeof record, stop)) return broken();
  const auto is_picture_of = [&](int width, int height) {
    return width > 0 && height > 0 &&
           record.bytes == 3ull * static_cast<unsigned>(width) * static_cast<unsigned>(height);
  };
  if (record.bytes > largest_picture_bytes ||
      (record.kind == Kind::bgr && !is_picture_of(record.width_px, record.height_px)))
    return broken();
  if (record.kind == Kind::bgr) {
    event.bgr.create(record.height_px, record.width_px, CV_8UC3);
    if (!read(event.bgr.data, record.bytes, stop)) return broken();
  } else if (record.kind == Kind::jpeg) {
    event.jpeg.resize(record.bytes);
    if (!read(event.jpeg.data(), record.bytes, stop)) return broken();
    event.bgr = decode_jpeg(event.jpeg);
  } else {
    event.error.resize(record.bytes);
    if (!read(event.error.data(), record.bytes, stop)) return broken();
  }
  if (record.quarter_turns > 0 && record.quarter_turns < 4 && !event.bgr.empty())
    cv::rotate(event.bgr, event.bgr, record.quarter_turns - 1);  // ROTATE_90_CLOCKWISE, ROTATE_180, ...
  return event;
}

}  // namespace arkmesh::tracker
