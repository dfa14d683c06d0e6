#include "tracker/camera/jpeg_stream.hpp"

#include <jerror.h>
#include <jpeglib.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

namespace arkmesh::tracker {
namespace {

constexpr std::array<std::uint8_t, 3> begin_marker{0xFF, 0xD8, 0xFF};
constexpr std::uint8_t start_of_image = 0xD8, end_of_image = 0xD9, start_of_scan = 0xDA, first_note = 0xE0,
                       last_note = 0xFE;
constexpr std::size_t longest_head = 2048;  // of a part in a multipart stream; more bytes are a picture that is none
constexpr std::int64_t max_camera_pixels = 64ll << 20, max_file_pixels = 1ll << 30;

struct Decoder {
  Decoder() = default;
  ~Decoder() { jpeg_destroy_decompress(&reader); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  jpeg_decompress_struct reader{};
  jpeg_error_mgr errors{};
  std::jmp_buf failed;
};

// Pixels are missing, which the library would fill with grey. Other warnings, as of noise behind the pixels, cost none.
bool costs_pixels(int warning) {
  return warning == JWRN_HIT_MARKER || warning == JWRN_JPEG_EOF || warning == JWRN_HUFF_BAD_CODE ||
         warning == JWRN_MUST_RESYNC;
}

// BGR, or what has four colours as it is, its sides divided by `shrink`. Empty: damaged, perhaps damaged, or of too
// many pixels.
void decode_rows(std::span<const std::uint8_t> jpeg, unsigned shrink, std::int64_t most_pixels, Decoder& decoder,
                 cv::Mat& picture) {
  jpeg_decompress_struct& reader = decoder.reader;
  reader.err = jpeg_std_error(&decoder.errors);
  reader.client_data = &decoder;
  decoder.errors.error_exit = [](j_common_ptr all) {
    std::longjmp(static_cast<Decoder*>(all->client_data)->failed, 1);
  };
  decoder.errors.emit_message = [](j_common_ptr all, int level) {
    if (level < 0 && costs_pixels(all->err->msg_code)) all->err->error_exit(all);
  };
  if (setjmp(decoder.failed) != 0) return picture.release();
  jpeg_create_decompress(&reader);
  jpeg_mem_src(&reader, jpeg.data(), jpeg.size());
  jpeg_read_header(&reader, TRUE);
  if (reader.arith_code) return picture.release();  // which decodes to something whatever is damaged or missing
  if (std::int64_t{reader.image_width} * reader.image_height > most_pixels) return picture.release();
  reader.out_color_space = reader.num_components > 3 ? JCS_CMYK : JCS_EXT_BGR;
  reader.scale_denom = shrink;
  jpeg_start_decompress(&reader);
  picture.create(static_cast<int>(reader.output_height), static_cast<int>(reader.output_width),
                 CV_8UC(reader.output_components));
  while (reader.output_scanline < reader.output_height) {
    JSAMPROW row = picture.ptr(static_cast<int>(reader.output_scanline));
    jpeg_read_scanlines(&reader, &row, 1);
  }
}

}  // namespace

void JpegStream::drop(std::size_t bytes) {
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(bytes));
  at_ = 0;
  in_scan_ = false;
}

// Goes on through the picture at the front. At its end `at_` is behind its last marker; where it is damaged, at what
// may be the next picture.
JpegStream::Step JpegStream::walk() {
  while (at_ + 1 < bytes_.size()) {
    if (in_scan_) {
      const void* const mark = std::memchr(bytes_.data() + at_, 0xFF, bytes_.size() - at_);
      at_ = mark ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(mark) - bytes_.data()) : bytes_.size();
      if (at_ + 1 >= bytes_.size()) break;
      const std::uint8_t kind = bytes_[at_ + 1];
      if (kind == 0 || (kind >= 0xD0 && kind <= 0xD7)) {  // a byte of the pixels, or a place to begin again
        at_ += 2;
        continue;
      }
      if (kind == 0xFF) {
        ++at_;
        continue;
      }
      in_scan_ = false;
    }
    const std::uint8_t kind = bytes_[at_ + 1];
    if (bytes_[at_] != 0xFF || kind == start_of_image || kind == 0) return Step::damaged;
    if (kind == end_of_image) {
      at_ += 2;
      return Step::picture;
    }
    if (kind == 0xFF) {
      ++at_;
      continue;
    }
    if (at_ + 3 >= bytes_.size()) break;
    const std::size_t length = static_cast<std::size_t>(bytes_[at_ + 2]) << 8 | bytes_[at_ + 3];
    if (length < 2) return Step::damaged;
    const std::size_t end = at_ + 2 + length;
    if (end > bytes_.size()) break;
    // tables that are cut run into the next picture; notes may hold a small one
    if (kind < first_note || kind > last_note) {
      const auto from = bytes_.begin() + static_cast<std::ptrdiff_t>(at_),
                 to = bytes_.begin() + static_cast<std::ptrdiff_t>(end);
      const auto other = std::search(from, to, begin_marker.begin(), begin_marker.end());
      if (other != to) {
        at_ += static_cast<std::size_t>(other - from);
        return Step::damaged;
      }
    }
    in_scan_ = kind == start_of_scan;
    at_ = end;
  }
  return bytes_.size() > max_bytes ? Step::damaged : Step::more;
}

std::optional<std::vector<std::uint8_t>> JpegStream::next() {
  while (true) {
    if (at_ == 0) {
      const auto first = std::search(bytes_.begin(), bytes_.end(), begin_marker.begin(), begin_marker.end());
      const bool found = first != bytes_.end();
      // the last two may be a beginning
      const std::size_t skipped = found ? static_cast<std::size_t>(first - bytes_.begin())
                                        : bytes_.size() - std::min<std::size_t>(bytes_.size(), 2);
      drop(skipped);
      between_ += skipped;
      if (!found) return {};
      if (std::exchange(between_, 0) > longest_head) ++damaged_;
      at_ = 2;
    }
    switch (walk()) {
      case Step::more:
        return {};
      case Step::picture: {
        const std::size_t end = at_;
        std::vector<std::uint8_t> picture(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(end));
        drop(end);
        return picture;
      }
      case Step::damaged:
        ++damaged_;
        // never back to the same beginning
        drop(std::clamp<std::size_t>(at_, 1, bytes_.size()));
    }
  }
}

void JpegStream::end() {
  damaged_ += at_ > 0 || between_ > longest_head;
  drop(bytes_.size());
  between_ = 0;
}

cv::Mat decode_jpeg(std::span<const std::uint8_t> jpeg) {
  // Memory of pictures that nobody has any more: the kernel takes 0.4 ms to give 6 MB of new memory.
  thread_local std::array<cv::Mat, 3> kept;
  const auto is_free = [](const cv::Mat& one) { return !one.u || CV_XADD(&one.u->refcount, 0) == 1; };
  try {
    // OpenCV takes as long again to turn RGB into BGR
    cv::Mat other;
    const auto spare = std::ranges::find_if(kept, is_free);
    cv::Mat& picture = spare == kept.end() ? other : *spare;
    Decoder decoder;
    decode_rows(jpeg, 1, max_camera_pixels, decoder, picture);
    if (picture.channels() < 4) return picture;
    const cv::Mat bytes(1, static_cast<int>(jpeg.size()), CV_8UC1, const_cast<std::uint8_t*>(jpeg.data()));
    return cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

bool lacks_pixels(std::span<const std::uint8_t> file) {
  if (file.size() < begin_marker.size() || !std::equal(begin_marker.begin(), begin_marker.end(), file.begin()))
    return false;
  cv::Mat small;
  Decoder decoder;
  decode_rows(file, 8, max_file_pixels, decoder, small);
  return small.empty();
}

}  // namespace arkmesh::tracker
