#include "testbed/raw_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>

namespace arkmesh::testbed {
namespace {

constexpr std::size_t longest_line = 64 << 10, most_cameras = 4;
constexpr std::int64_t a_week_us = 7ll * 24 * 3600 * 1'000'000;

// The first word of `rest`, which then begins behind it.
std::string_view take_word(std::string_view& rest) {
  const std::size_t end = std::min(rest.find(' '), rest.size());
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return word;
}

// A whole number from 0 to `most`; nothing when it is none.
std::optional<std::int64_t> number_of(std::string_view word, std::int64_t most) {
  std::int64_t out = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  if (error != std::errc() || end != word.data() + word.size() || out < 0 || out > most) return {};
  return out;
}

std::optional<int> hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return {};
}

std::optional<std::vector<std::uint8_t>> bytes_of(std::string_view hex) {
  if (hex.empty() || hex.size() % 2 != 0) return {};
  std::vector<std::uint8_t> out;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    const auto high = hex_digit(hex[i]), low = hex_digit(hex[i + 1]);
    if (!high || !low) return {};
    out.push_back(static_cast<std::uint8_t>(*high << 4 | *low));
  }
  return out;
}

// "000012.png@1034567"
std::optional<LookedAt> looked_at(std::string_view word) {
  if (word == "-") return LookedAt{};
  if (word == "lost") return LookedAt{.what = LookedAt::What::lost, .file = {}};
  const std::size_t at = word.find('@');
  if (at == std::string_view::npos || at < 5 || at > 24) return {};
  const std::string_view file = word.substr(0, at);
  const auto arrived = number_of(word.substr(at + 1), a_week_us);
  const bool digits = std::ranges::all_of(file.substr(0, at - 4), [](char c) { return c >= '0' && c <= '9'; });
  if (!arrived || !digits || (!file.ends_with(".png") && !file.ends_with(".jpg"))) return {};
  return LookedAt{LookedAt::What::picture, std::string(file), *arrived};
}

std::size_t big_endian(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t count) {
  std::size_t out = 0;
  for (std::size_t i = at; i < at + count; ++i) out = out << 8 | bytes[i];
  return out;
}

std::optional<std::pair<int, int>> jpeg_size(std::span<const std::uint8_t> bytes) {
  for (std::size_t at = 2; at + 9 <= bytes.size();) {
    if (bytes[at] != 0xFF) return {};
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // filler
      ++at;
      continue;
    }
    // C4, C8 and CC are tables; the other ones from C0 to CF begin a picture
    if (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC)
      return std::pair(static_cast<int>(big_endian(bytes, at + 7, 2)), static_cast<int>(big_endian(bytes, at + 5, 2)));
    const std::size_t length = big_endian(bytes, at + 2, 2);
    if (length < 2) return {};
    at += 2 + length;
  }
  return {};
}

}  // namespace

std::string camera_folder(std::size_t number) {
  return fmt::format("camera{}", number);
}

std::string calibration_file_of(std::size_t number) {
  return fmt::format("calibration/{}.yaml", number);
}

RecordLines::RecordLines(std::istream& in, std::string name, std::string_view head)
    : in_(in), name_(std::move(name)), line_(longest_line + 1) {
  const auto first = next();
  if (!first || *first != head)
    throw RecordError(
        fmt::format("{} does not begin with \"{}\": is it a record of this version of arkmesh?", name_, head));
}

std::optional<std::string_view> RecordLines::next() {
  if (cut_ || !in_) return {};
  in_.getline(line_.data(), static_cast<std::streamsize>(line_.size()));
  const auto count = static_cast<std::size_t>(in_.gcount());
  if (in_.eof()) {  // whole lines end with their newline
    cut_ = count > 0;
    return {};
  }
  ++number_;
  if (!in_) refuse("is longer than any line of a record");
  return std::string_view(line_.data(), count - 1);
}

void RecordLines::refuse(std::string_view why) const {
  throw RecordError(fmt::format("{}:{}: this line {}; the record is damaged from there on", name_, number_, why));
}

SerialLines::SerialLines(std::istream& in, std::string name) : lines_(in, std::move(name), serial_head) {}

std::optional<SerialEvent> SerialLines::next() {
  const auto line = lines_.next();
  if (!line) return {};
  std::string_view rest = *line;
  const auto time = number_of(take_word(rest), a_week_us);
  if (!time) lines_.refuse("does not begin with a time in microseconds, from 0 to a week");
  if (*time < last_us_) lines_.refuse("has an earlier time than the one before it");
  last_us_ = *time;

  using Kind = SerialEvent::Kind;
  static constexpr std::pair<std::string_view, Kind> kinds[] = {{"opening", Kind::opening}, {"open", Kind::open},
                                                                {"closed", Kind::closed},   {"wrote", Kind::wrote},
                                                                {"heard", Kind::heard},     {"end", Kind::end}};
  const std::string_view word = take_word(rest);
  const auto kind = std::ranges::find(kinds, word, &std::pair<std::string_view, Kind>::first);
  if (kind == std::end(kinds)) lines_.refuse("is not an entry of a serial line");
  SerialEvent out{.time_us = *time, .kind = kind->second, .bytes = {}, .about = {}};
  if (out.kind == Kind::wrote || out.kind == Kind::heard) {
    auto bytes = bytes_of(rest);
    if (!bytes) lines_.refuse("does not contain whole bytes in hexadecimal");
    out.bytes = std::move(*bytes);
  } else {
    out.about = rest;
  }
  return out;
}

LookLines::LookLines(std::istream& in, std::string name) : lines_(in, std::move(name), looks_head) {}

std::optional<std::variant<LookLine, FrameLine>> LookLines::next() {
  const auto line = lines_.next();
  if (!line) return {};
  std::string_view rest = *line;
  const std::string_view word = take_word(rest);
  const auto first = number_of(take_word(rest), a_week_us), second = number_of(take_word(rest), a_week_us);
  if (!first || !second || (word != "look" && word != "frame")) lines_.refuse("is neither a look nor a frame");
  if (word == "frame") {
    if (*first > INT32_MAX || !rest.empty()) lines_.refuse("is neither a look nor a frame");
    return FrameLine{static_cast<std::uint32_t>(*first), hal::LabTime(*second)};
  }
  LookLine out{.now = hal::LabTime(*first), .time_us = *second, .camera = {}};
  while (!rest.empty()) {
    auto seen = looked_at(take_word(rest));
    if (!seen) lines_.refuse("names no picture in the form of a record");
    out.camera.push_back(std::move(*seen));
    if (out.camera.size() > most_cameras) lines_.refuse(fmt::format("has more than {} cameras", most_cameras));
  }
  if (out.camera.empty() || (!last_.camera.empty() && out.camera.size() != last_.camera.size()))
    lines_.refuse("has another number of cameras than the one before it");
  if (out.now < last_.now || out.time_us < last_.time_us) lines_.refuse("has an earlier time than the one before it");
  last_ = out;
  return out;
}

std::optional<std::pair<int, int>> picture_size(std::span<const std::uint8_t> bytes) {
  constexpr std::uint8_t png[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  if (bytes.size() >= 24 && std::ranges::equal(bytes.first(sizeof png), png)) {
    const std::size_t width = big_endian(bytes, 16, 4), height = big_endian(bytes, 20, 4);
    if (width > INT32_MAX || height > INT32_MAX) return {};
    return std::pair(static_cast<int>(width), static_cast<int>(height));
  }
  if (bytes.size() >= 2 && bytes[0] == 0xFF && bytes[1] == 0xD8) return jpeg_size(bytes);
  return {};
}

}  // namespace arkmesh::testbed
