#include "recording/export/json.hpp"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace arkmesh::recording {
namespace {

using namespace hal::layout;

class JsonWriter : public Visitor {
 public:
  explicit JsonWriter(std::string& to) : to_(to) {}

  void value(const Field& field, const Value& value) override {
    name(field);
    char digits[32];
    const auto put = [&](auto number) {
      to_.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
    };
    switch (value.kind) {
      case Kind::text:
        append_json_text(to_, value.text);
        break;
      case Kind::boolean:
        to_ += value.integer != 0 ? "true" : "false";
        break;
      case Kind::float32:
      case Kind::float64:
        if (!std::isfinite(value.real))
          to_ += "null";
        else if (value.kind == Kind::float32)
          put(static_cast<float>(value.real));
        else
          put(value.real);
        break;
      default:
        put(value.integer);
        break;
    }
  }
  void bytes(const Field& field, std::span<const std::byte> bytes) override {
    name(field);
    to_ += '[';
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (i > 0) to_ += ',';
      to_ += std::to_string(std::to_integer<unsigned>(bytes[i]));
    }
    to_ += ']';
  }
  void begin_list(const Field& field, std::size_t) override {
    name(field);
    to_ += '[';
    in_list_ = true;
  }
  void end_list(const Field&) override {
    to_ += ']';
    in_list_ = false;
  }
  void begin_record(const Field& field, std::size_t) override {
    name(field);
    to_ += '{';
    in_list_ = false;
  }
  void end_record(const Field& field) override {
    to_ += '}';
    in_list_ = !field.sizes.empty();
  }

 private:
  // What stands before a value: a comma, and in an object its name.
  void name(const Field& field) {
    if (to_.back() != '{' && to_.back() != '[') to_ += ',';
    if (in_list_) return;
    to_ += '"';
    to_ += field.name;
    to_ += "\":";
  }

  std::string& to_;
  bool in_list_ = false;  // where values have no name
};

}  // namespace

void append_json(std::string& to, const Type& type, std::span<const std::byte> message) {
  to += '{';
  JsonWriter writer(to);
  visit(type, message, writer);
  to += '}';
}

void append_json_text(std::string& to, std::string_view text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) >= 127 || static_cast<unsigned char>(c) < ' ' || c == '"' || c == '\\') {
      to += nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
      return;
    }
  to += '"';
  to += text;
  to += '"';
}

}  // namespace arkmesh::recording
