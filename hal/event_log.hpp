// Reads LCM event logs that may be truncated, foreign or damaged, one event at a time, with sizes checked before memory
// is asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

namespace arkmesh::hal {

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
