// Videos and motion JPEG from anywhere: bytes of a stream in parts of any length, or a whole file. Whatever comes,
// pictures have the bytes that they say, JPEGs begin and end as such, and parts of any length give the same pictures.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "tracker/camera/jpeg_stream.hpp"
#include "tracker/camera/picture_reader.hpp"

namespace {

using namespace arkmesh::tracker;
using Jpegs = std::vector<std::vector<std::uint8_t>>;

void require(bool condition) {
  if (!condition) std::abort();
}

void require_jpeg(std::span<const std::uint8_t> jpeg) {
  require(jpeg.size() >= 4 && jpeg[0] == 0xFF && jpeg[1] == 0xD8);
  require(jpeg[jpeg.size() - 2] == 0xFF && jpeg.back() == 0xD9);
}

std::pair<Jpegs, std::size_t> split(std::span<const std::uint8_t> bytes, std::size_t part) {
  JpegStream stream;
  Jpegs all;
  while (!bytes.empty()) {
    const std::size_t n = std::min(part, bytes.size());
    stream.add(bytes.first(n));
    bytes = bytes.subspan(n);
    while (auto jpeg = stream.next()) all.push_back(std::move(*jpeg));
  }
  stream.end();
  return {std::move(all), stream.take_damaged()};
}

void read_stream(std::span<const std::uint8_t> bytes, std::size_t part) {
  const auto [jpegs, damaged] = split(bytes, part);
  require(split(bytes, bytes.size()) == std::pair(jpegs, damaged));
  for (const auto& jpeg : jpegs) {
    require_jpeg(jpeg);
    const cv::Mat picture = decode_jpeg(jpeg);
    require(picture.empty() || picture.type() == CV_8UC3);
  }
}

void read_file(std::span<const std::uint8_t> bytes) {
  const int file = ::memfd_create("fuzz", 0);
  require(file >= 0 && ::write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  int records = 0;
  read_pictures({.path = path, .shown = "fuzz"}, [&](const PictureRecord& record, std::span<const std::uint8_t> data) {
    using Kind = PictureRecord::Kind;
    require(record.bytes == data.size());
    if (record.kind == Kind::jpeg) require_jpeg(data);
    if (record.kind == Kind::bgr)
      require(record.width_px > 0 && record.height_px > 0 &&
              data.size() ==
                  3 * static_cast<std::size_t>(record.width_px) * static_cast<std::size_t>(record.height_px));
    if (record.kind == Kind::failed) require(!data.empty());
    return ++records < 20;
  });
  ::close(file);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::span bytes(data + 1, size - 1);
  if (data[0] < 128)
    read_stream(bytes, 1 + data[0]);
  else
    read_file(bytes);
  return 0;
}
