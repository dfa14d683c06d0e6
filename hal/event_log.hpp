// The format of LCM event logs, and their reading in order: logs may be truncated, foreign or damaged, one event at a
// time, with sizes checked before memory is asked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

namespace arkmesh::hal {

// What stands before the channel and the data of each event.
struct EventHeader {
  using Bytes = std::array<std::byte, 28>;

  std::int64_t number = 0;
  std::int64_t utime = 0;  // microseconds since 1970
  std::uint32_t channel_bytes = 0, data_bytes = 0;

  // Whether the first 4 bytes are those of an event.
  static bool begins(const Bytes& bytes);
  // Nothing when the bytes are no header, or one that no recorder writes: channels above 255 bytes, messages above
  // 64 MiB, times beyond the year 30000.
  static std::optional<EventHeader> from(const Bytes& bytes);
  Bytes bytes() const;
};

struct LogEvent {
  std::int64_t number = 0;
  std::int64_t utime = 0;  // microseconds since 1970
  std::string channel;
  std::vector<std::byte> bytes;
};

class EventLogReader {
 public:
  // Throws std::runtime_error with one sentence when the file cannot be opened or does not begin with an event.
  explicit EventLogReader(const std::filesystem::path& file);
  // Nothing at the end, or at the first damaged or cut event (then truncated() is true).
  std::optional<LogEvent> next();
  bool truncated() const { return truncated_; }

 private:
  std::ifstream in_;
  bool truncated_ = false;
};

}  // namespace arkmesh::hal
