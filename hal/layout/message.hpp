// Takes a message of any of our types apart, by the tables of types.hpp. The bytes may come from anywhere: every size
// in them is checked against the bytes that are left, so nothing is read or asked for beyond them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "hal/layout/types.hpp"

namespace arkmesh::hal::layout {

// A single value. `kind` says which of the others holds it: `real` for both floats, `text` for texts, else `integer`.
struct Value {
  Kind kind = Kind::int32;
  std::int64_t integer = 0;
  double real = 0;
  std::string_view text;  // of the message's bytes, without the final NUL
};

// What a message is made of, in its order. Lists of bytes come as one; lists of more dimensions as one long list.
class Visitor {
 public:
  virtual ~Visitor() = default;
  virtual void value(const Field& field, const Value& value) = 0;
  virtual void bytes(const Field& field, std::span<const std::byte> bytes) = 0;
  virtual void begin_list(const Field& field, std::size_t count) = 0;
  virtual void end_list(const Field& field) = 0;
  // Around each record: those of a list by its place in it, and single ones with place 0.
  virtual void begin_record(const Field& field, std::size_t place) = 0;
  virtual void end_record(const Field& field) = 0;
};

// The type that the first 8 bytes name; null: none of ours, or another version's.
const Type* type_of(std::span<const std::byte> message, const Types& types);
// Empty when the bytes are exactly one well-formed message of this type, else the reason in one word, fit for a
// counter's name: "fingerprint", "truncated", "count", "text", "trailing". No text may take more than `longest_text`
// bytes, its final NUL included.
std::string_view check(const Type& type, std::span<const std::byte> message,
                       std::size_t longest_text = std::numeric_limits<std::size_t>::max());
// Shows the visitor a message that check() has passed. What it has not, it shows up to the damage.
void visit(const Type& type, std::span<const std::byte> message, Visitor& visitor);

// An unsigned big-endian number of 1 to 8 bytes.
inline std::uint64_t big_endian(std::span<const std::byte> bytes) {
  std::uint64_t out = 0;
  for (const std::byte b : bytes) out = out << 8 | std::to_integer<std::uint64_t>(b);
  return out;
}

}  // namespace arkmesh::hal::layout
