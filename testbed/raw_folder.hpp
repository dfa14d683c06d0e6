// Reads what RawRecord wrote, line by line. A folder may come from anywhere and be cut, damaged or endless: memory
// stays small, a last line that is cut is left out, and anything else that is wrong ends in one sentence.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "hal/types.hpp"

namespace arkmesh::testbed {

inline constexpr const char *serial_file = "serial.txt", *looks_file = "looks.txt";
inline constexpr const char *serial_head = "# arkmesh serial line 1", *looks_head = "# arkmesh looks 1";
// Of camera `number`, as they lie below the folder.
std::string camera_folder(std::size_t number);
std::string calibration_file_of(std::size_t number);

// One sentence: which file and line, and what is wrong there.
class RecordError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Lines of at most 64 KiB that begin with `head` and then hold a time each. `in` outlives it.
class RecordLines {
 public:
  // `name` stands for the file in messages. Throws RecordError when it does not begin with `head`.
  RecordLines(std::istream& in, std::string name, std::string_view head);
  // Without its end. Nothing behind the last whole one.
  std::optional<std::string_view> next();
  // Something without an end was left out.
  bool cut() const { return cut_; }
  [[noreturn]] void refuse(std::string_view why) const;

 private:
  std::istream& in_;
  std::string name_;
  std::vector<char> line_;
  std::uint64_t number_ = 0;
  bool cut_ = false;
};

struct SerialEvent {
  enum class Kind : std::uint8_t { opening, open, closed, wrote, heard, end };
  std::int64_t time_us = 0;  // since the record began, never decreasing, a week at most
  Kind kind = Kind::end;
  std::vector<std::uint8_t> bytes;  // wrote, heard
  std::string about;                // opening, open: the port; closed: why, if that is known
};

// serial.txt
class SerialLines {
 public:
  SerialLines(std::istream& in, std::string name);
  // Throws RecordError.
  std::optional<SerialEvent> next();
  bool cut() const { return lines_.cut(); }

 private:
  RecordLines lines_;
  std::int64_t last_us_ = 0;
};

struct LookedAt {
  enum class What : std::uint8_t { nothing, lost, picture } what = What::nothing;
  std::string file;             // of a picture, below its camera's folder: digits, and .png or .jpg
  std::int64_t arrived_us = 0;  // when the camera gave it, since the record began
};
struct LookLine {
  hal::LabTime now{0};           // what the monitor was told; never decreasing, a week at most
  std::int64_t time_us = 0;      // since the record began
  std::vector<LookedAt> camera;  // each; one to four
};
// The lab took the last look's poses as that frame.
struct FrameLine {
  std::uint32_t number = 0;
  hal::LabTime stamp{0};
};

// looks.txt
class LookLines {
 public:
  LookLines(std::istream& in, std::string name);
  // Throws RecordError.
  std::optional<std::variant<LookLine, FrameLine>> next();
  bool cut() const { return lines_.cut(); }

 private:
  RecordLines lines_;
  LookLine last_;
};

// Width and height of a PNG or JPEG by its head; nothing when the bytes are neither. For whoever wants to know before
// memory is asked for.
std::optional<std::pair<int, int>> picture_size(std::span<const std::uint8_t> bytes);

}  // namespace arkmesh::testbed
