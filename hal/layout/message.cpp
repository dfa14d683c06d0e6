#include "hal/layout/message.hpp"

#include <algorithm>
#include <cstring>

namespace arkmesh::hal::layout {
namespace {

class Walk {
 public:
  // `visitor` null: only looks whether the bytes are well formed.
  Walk(std::span<const std::byte> bytes, Visitor* visitor, std::size_t longest_text)
      : bytes_(bytes), visitor_(visitor), longest_text_(longest_text) {}

  std::string_view message(const Type& type) {
    if (number(8) != type.fingerprint) fail("fingerprint");
    record(type);
    if (good() && left() != 0) fail("trailing");
    return why_;
  }

 private:
  void record(const Type& type) {
    std::int64_t sizes[Type::max_slots] = {};
    for (const Field& field : type.fields) {
      if (!good()) return;
      if (!field.sizes.empty())
        list(field, sizes);
      else
        one(field, 0, field.slot >= 0 ? &sizes[field.slot] : nullptr);
    }
  }

  void list(const Field& field, const std::int64_t* sizes) {
    const std::size_t each = std::max<std::size_t>(1, least_bytes_of(field));
    std::size_t count = 1;
    for (const Dimension& size : field.sizes) {
      const std::int64_t n = size.slot >= 0 ? sizes[size.slot] : size.fixed;
      // what is left bounds the product of all sizes, so it does not overflow
      if (n < 0 || (count != 0 && static_cast<std::uint64_t>(n) > left() / each / count)) return fail("count");
      count *= static_cast<std::size_t>(n);
    }
    if (field.kind == Kind::byte) {
      if (visitor_) visitor_->bytes(field, bytes_.subspan(at_, count));
      at_ += count;
      return;
    }
    if (!visitor_ && (field.type ? field.type->is_fixed : field.kind != Kind::text)) {
      at_ += count * each;
      return;
    }
    if (visitor_) visitor_->begin_list(field, count);
    for (std::size_t i = 0; i < count && good(); ++i) one(field, i, nullptr);
    if (visitor_) visitor_->end_list(field);
  }

  // `told`: where the value is kept, being the size of a list.
  void one(const Field& field, std::size_t place, std::int64_t* told) {
    if (field.kind == Kind::record) {
      if (visitor_) visitor_->begin_record(field, place);
      record(*field.type);
      if (visitor_) visitor_->end_record(field);
      return;
    }
    Value value;
    value.kind = field.kind;
    switch (field.kind) {
      case Kind::int8:
        value.integer = static_cast<std::int8_t>(number(1));
        break;
      case Kind::boolean:
        value.integer = number(1) != 0;
        break;
      case Kind::byte:
        value.integer = static_cast<std::int64_t>(number(1));
        break;
      case Kind::int16:
        value.integer = static_cast<std::int16_t>(number(2));
        break;
      case Kind::int32:
        value.integer = static_cast<std::int32_t>(number(4));
        break;
      case Kind::int64:
        value.integer = static_cast<std::int64_t>(number(8));
        break;
      case Kind::float32:
        value.real = std::bit_cast<float>(static_cast<std::uint32_t>(number(4)));
        break;
      case Kind::float64:
        value.real = std::bit_cast<double>(number(8));
        break;
      case Kind::text:
        value.text = text();
        break;
      case Kind::record:
        break;
    }
    if (!good()) return;
    if (told) *told = value.integer;
    if (visitor_) visitor_->value(field, value);
  }

  // LCM text: length with its final NUL, then the bytes.
  std::string_view text() {
    const auto n = static_cast<std::int32_t>(number(4));
    if (!good()) return {};
    if (n < 1 || static_cast<std::size_t>(n) > std::min(left(), longest_text_)) return fail("text"), std::string_view();
    const auto* const begin = reinterpret_cast<const char*>(bytes_.data() + at_);
    if (std::memchr(begin, 0, static_cast<std::size_t>(n)) != begin + n - 1) return fail("text"), std::string_view();
    at_ += static_cast<std::size_t>(n);
    return {begin, static_cast<std::size_t>(n) - 1};
  }

  std::uint64_t number(std::size_t n) {
    if (n > left()) return fail("truncated"), 0;
    const std::uint64_t out = big_endian(bytes_.subspan(at_, n));
    at_ += n;
    return out;
  }

  std::size_t left() const { return bytes_.size() - at_; }
  bool good() const { return why_.empty(); }
  void fail(std::string_view why) {
    if (why_.empty()) why_ = why;
    at_ = bytes_.size();
  }

  std::span<const std::byte> bytes_;
  Visitor* visitor_;
  std::size_t longest_text_;
  std::size_t at_ = 0;
  std::string_view why_;
};

}  // namespace

const Type* type_of(std::span<const std::byte> message, const Types& types) {
  return message.size() < 8 ? nullptr : types.find(big_endian(message.first(8)));
}

std::string_view check(const Type& type, std::span<const std::byte> message, std::size_t longest_text) {
  return Walk(message, nullptr, longest_text).message(type);
}

void visit(const Type& type, std::span<const std::byte> message, Visitor& visitor) {
  Walk(message, &visitor, message.size()).message(type);
}

}  // namespace arkmesh::hal::layout
