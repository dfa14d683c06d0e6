// Walks the bytes of a message that came from outside and checks every count in it, nested ones too, against the bytes
// that are left. LCM's generated decoders trust counts, so nothing from outside is decoded before this has passed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace arkmesh::hal {

class MessageWalker {
 public:
  // Texts in our messages are names, reasons and settings; none is longer.
  static constexpr std::int32_t max_text = 4096;
  static constexpr std::size_t min_text = 5;  // bytes of an empty one

  // `bytes` outlive the walker.
  explicit MessageWalker(std::span<const std::byte> bytes) : bytes_(bytes) {}

  void fingerprint(std::int64_t expected) {
    if (static_cast<std::int64_t>(big_endian(8)) != expected) fail("fingerprint");
  }
  void skip(std::size_t n) {
    if (n > left()) return fail("truncated");
    at_ += n;
  }
  // A count of elements that take at least `min_bytes` each.
  std::int32_t count(std::size_t min_bytes) {
    const auto n = static_cast<std::int32_t>(big_endian(4));
    if (n < 0 || static_cast<std::size_t>(n) > left() / min_bytes) return fail("count"), 0;
    return n;
  }
  // LCM text: length with its final NUL, then the bytes.
  void text() {
    const auto n = static_cast<std::int32_t>(big_endian(4));
    if (!good()) return;
    if (n < 1 || n > max_text || static_cast<std::size_t>(n) > left()) return fail("text");
    for (std::int32_t i = 0; i < n; ++i)
      if ((bytes_[at_ + static_cast<std::size_t>(i)] == std::byte{0}) != (i == n - 1)) return fail("text");
    at_ += static_cast<std::size_t>(n);
  }
  // `each` walks one element.
  template <class Each>
  void list(std::size_t min_bytes, Each each) {
    for (std::int32_t n = count(min_bytes); n > 0 && good(); --n) each();
  }
  // A count of elements of `bytes` each, and the elements.
  void array(std::size_t bytes) { skip(bytes * static_cast<std::size_t>(count(bytes))); }

  bool good() const { return why_.empty(); }
  // At the end: empty when the bytes are exactly one well-formed message, else the reason in one word ("fingerprint",
  // "truncated", "count", "text", "trailing"), fit for a counter's name.
  std::string_view verdict() {
    if (good() && left() != 0) fail("trailing");
    return why_;
  }

 private:
  std::size_t left() const { return bytes_.size() - at_; }
  std::uint64_t big_endian(std::size_t n) {
    if (n > left()) return fail("truncated"), 0;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes_[at_ + i]);
    at_ += n;
    return value;
  }
  void fail(std::string_view why) {
    if (why_.empty()) why_ = why;
    at_ = bytes_.size();
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::string_view why_;
};

}  // namespace arkmesh::hal
