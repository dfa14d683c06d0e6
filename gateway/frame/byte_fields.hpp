// Integers, names and bytes one after the other, as gateways write what they tell each other: big-endian. Pure.
#pragma once

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::gateway {

template <class Integer>
void put(std::vector<std::byte>& out, Integer value) {
  const Integer big = boost::endian::native_to_big(value);
  const auto bytes = std::as_bytes(std::span(&big, 1));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

inline void put_bytes(std::vector<std::byte>& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}
// At most 255 bytes of text.
inline void put_name(std::vector<std::byte>& out, std::string_view name) {
  put(out, static_cast<std::uint8_t>(name.size()));
  put_bytes(out, std::as_bytes(std::span(name)));
}

// Takes values from the front; after the first that is not there all are zero and good() is false.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class Integer>
  Integer take() {
    Integer value{};
    std::ranges::copy(take_bytes(sizeof value), std::as_writable_bytes(std::span(&value, 1)).begin());
    return boost::endian::big_to_native(value);
  }
  std::string_view take_text(std::size_t size) {
    const auto bytes = take_bytes(size);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::string take_name() { return std::string(take_text(take<std::uint8_t>())); }
  std::span<const std::byte> take_bytes(std::size_t size) {
    if (!good_ || rest_.size() < size) {
      good_ = false;
      return {};
    }
    const auto bytes = rest_.first(size);
    rest_ = rest_.subspan(size);
    return bytes;
  }
  std::span<const std::byte> rest() const { return rest_; }
  bool good() const { return good_; }
  bool at_end() const { return good_ && rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
  bool good_ = true;
};

}  // namespace arkmesh::gateway
