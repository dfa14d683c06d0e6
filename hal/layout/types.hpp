// The LCM types of lcmtypes/ as data: what a message holds, for code that shows, exports or checks messages of any
// type. The tables are made at build time by make_types.py; a new type or field is here by itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::hal::layout {

enum class Kind { int8, int16, int32, int64, float32, float64, boolean, byte, text, record };

struct Type;

// One size of a list: a number, or the value of an earlier field.
struct Dimension {
  std::int32_t fixed = 0;
  int slot = -1;  // which of the type's sizes (Field::slot); -1: `fixed` holds
};

struct Field {
  std::string name;
  std::string comment;  // as in the .lcm file
  std::string unit;     // by the end of the name: "m", "rad", "us", ...; empty: none
  Kind kind = Kind::int32;
  const Type* type = nullptr;    // of records
  std::vector<Dimension> sizes;  // none: a single value
  int slot = -1;                 // which of the type's sizes this field tells; -1: it is no size of another field
};

struct Type {
  static constexpr int max_slots = 16;

  std::string name;
  std::string comment;
  std::uint64_t fingerprint = 0;  // the first 8 bytes of a message of this type
  std::vector<Field> fields;
  std::size_t least_bytes = 0;  // no value of it takes less
  bool is_fixed = false;        // every value takes least_bytes
};

// A single value of the field takes no less. Of a record 0 when its type is empty.
std::size_t least_bytes_of(const Field& field);

class Types {
 public:
  // From a types.json. Throws std::runtime_error when it is none.
  explicit Types(std::string_view json);

  const Type* find(std::string_view name) const;
  const Type* find(std::uint64_t fingerprint) const;
  // The type that this channel carries, of another lab (`shark/world`) too; null: the channel is not known.
  const Type* of_channel(std::string_view channel) const;
  const std::vector<std::unique_ptr<Type>>& all() const { return types_; }

 private:
  std::vector<std::unique_ptr<Type>> types_;
  std::map<std::string, const Type*, std::less<>> by_name_, by_channel_;
  std::map<std::uint64_t, const Type*> by_fingerprint_;
};

// What the end of a field's or column's name says of its unit: "m" of "x_m"; empty: nothing.
std::string unit_of(std::string_view name);

// Those of this build.
const Types& types();
// That of generated code, looked up once.
template <class Message>
const Type& type_for() {
  static const Type& type = *types().find(static_cast<std::uint64_t>(Message::getHash()));
  return type;
}
// The same as text, for who reads them elsewhere: view/PROTOCOL.md and make_types.py say how it is made.
std::string_view types_json();

}  // namespace arkmesh::hal::layout
