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
#include <string>
#include <string_view>
#include <vector>

#include "hal/files/packed_file.hpp"
#include "hal/handle.hpp"

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

  // False of what no recorder writes: channels of 0 or above 255 bytes, messages above 64 MiB, times beyond 30000 AD.
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
  // Nothing at the end, or at an event that is cut and has no whole one behind it. Goes on behind damage.
  std::optional<EventView> next();
  // The same, whose data are not read.
  std::optional<EventView> next_place();
  // The event of `size` bytes at an offset; nothing when the file holds none there.
  std::optional<EventView> read_at(std::uint64_t offset, std::size_t size);
  // Whether what was passed, or lies behind it, is not whole; and that in words, as in "its last 5 bytes are".
  bool truncated() const { return unread_bytes() > 0 || skipped_bytes() > 0; }
  std::string left_out() const;
  // Of damage between whole events that were passed; of a compressed log also packed ones.
  std::uint64_t skipped_bytes() const { return skipped_ + (packed_ ? packed_->skipped_bytes() : 0); }
  // Behind the events that were passed, as far as the file reached when it was opened or looked at last.
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
  // Whether the file holds all of it, on a channel with a name that people can read.
  bool is_whole(std::uint64_t place, const EventHeader& header);
  // Whether the file ends there, or another event begins.
  bool ends_at(std::uint64_t place);
  // The first place from `from` on, and before `to`, where a whole event begins that another one or the end follows.
  std::optional<std::uint64_t> find_event(std::uint64_t from, std::uint64_t to);

  Handle file_;
  std::optional<PackedFile> packed_;  // when it is compressed
  std::uint64_t size_ = 0;            // of the file when last looked at
  std::uint64_t end_ = 0;             // of the events that were passed
  std::uint64_t skipped_ = 0, gaps_ = 0;
  std::vector<std::byte> ahead_;  // bytes of the file from ahead_begin_ on
  std::uint64_t ahead_begin_ = 0;
  std::vector<std::byte> event_;  // of read_at()
};

}  // namespace arkmesh::hal
