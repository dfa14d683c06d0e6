// The format of LCM event logs, and their reading: logs may be truncated, foreign, damaged or still growing; one event
// at a time, with sizes checked before memory is asked for. Logs may be compressed (PackedFile); offsets and sizes are
// those of the plain log.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "hal/handle.hpp"
#include "hal/packed_file.hpp"

namespace arkmesh::hal {

inline constexpr const char *log_name = "log.lcm", *packed_log_name = "log.lcm.zst";
// The log in a lab's folder: log.lcm, or log.lcm.zst where only that is there. There may be none.
std::filesystem::path log_in(const std::filesystem::path& folder);

// What stands before the channel and the data of each event.
struct EventHeader {
  using Bytes = std::array<std::byte, 28>;

  std::int64_t number = 0;
  std::int64_t utime = 0;  // microseconds since 1970
  std::uint32_t channel_bytes = 0, data_bytes = 0;

  // False of what no recorder writes: channels above 255 bytes, messages above 64 MiB, times beyond the year 30000.
  bool is_sane() const;
  // Of the whole event.
  std::size_t size() const { return sizeof(Bytes) + channel_bytes + data_bytes; }
  Bytes encoded() const;
};

// An event in a reader's memory.
struct EventView : EventHeader {
  std::string_view channel;
  std::span<const std::byte> bytes;
};

// What it shows is valid until the next call of any of its functions.
class EventLogReader {
 public:
  // Throws std::runtime_error with one sentence when the file cannot be read or is no LCM log. It may be empty.
  explicit EventLogReader(const std::filesystem::path& file);
  // Nothing at the end, or at the first damaged or cut event (then truncated() is true).
  std::optional<EventView> next();
  // The same, whose data are not read.
  std::optional<EventView> next_place();
  // The event of `size` bytes at an offset; nothing when the file holds none there.
  std::optional<EventView> read_at(std::uint64_t offset, std::size_t size);
  // Behind the events that were passed, as far as the file reached when it was opened or looked at last.
  bool truncated() const { return unread_bytes() > 0; }
  std::uint64_t unread_bytes() const { return size_ - end_ + (packed_ ? packed_->unread_bytes() : 0); }
  std::uint64_t size() const { return size_; }
  // Where the next event begins, at most size().
  std::uint64_t place() const { return end_; }
  void go_to(std::uint64_t place) { end_ = place; }
  // Looks how far the file reaches now.
  void look_again();

 private:
  // Fewer bytes than wanted at the file's end. The second reads ahead.
  std::size_t read(std::uint64_t offset, std::span<std::byte> to);
  std::span<const std::byte> bytes_at(std::uint64_t offset, std::size_t n);

  Handle file_;
  std::optional<PackedFile> packed_;  // when it is compressed
  std::uint64_t size_ = 0;            // of the file when last looked at
  std::uint64_t end_ = 0;             // of the events that were passed
  std::vector<std::byte> ahead_;      // bytes of the file from ahead_begin_ on
  std::uint64_t ahead_begin_ = 0;
  std::vector<std::byte> event_;  // of read_at()
};

}  // namespace arkmesh::hal
