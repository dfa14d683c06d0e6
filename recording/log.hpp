// A lab's log.lcm with an index, so that a moment of a long run is found without reading what comes before it. The
// index is kept beside the log as log.index, and made anew where it is missing, damaged or of another log; the log
// itself is only read. Logs may be cut, damaged or still growing: what is whole counts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/record/event_log.hpp"

namespace arkmesh::recording {

class Log {
 public:
  // Where a message lies.
  struct Entry {
    std::int64_t t_us = 0;      // lab time, microseconds; 0 before the robots began to move; never decreases
    std::uint64_t offset = 0;   // of its event in the file
    std::uint32_t bytes = 0;    // of the message
    std::uint16_t channel = 0;  // an index of channels()
  };

  // Throws std::runtime_error with one sentence when the file cannot be read or is no LCM log.
  explicit Log(const std::filesystem::path& file);

  const std::filesystem::path& file() const { return file_; }
  const std::vector<std::string>& channels() const { return channels_; }
  // Every whole message, in the order of the log.
  std::span<const Entry> entries() const { return entries_; }
  // The messages of one channel, as indices of entries().
  std::span<const std::uint32_t> of_channel(std::size_t channel) const { return by_channel_[channel]; }
  std::optional<std::size_t> find_channel(std::string_view name) const;
  // The newest message of a channel at or before a time, as an index of entries().
  std::optional<std::uint32_t> newest(std::size_t channel, std::int64_t t_us) const;
  // Lab time of the last message.
  std::int64_t length_us() const { return entries_.empty() ? 0 : entries_.back().t_us; }
  // Microseconds since 1970 that lab time 0 stands for.
  std::int64_t start_utime() const { return start_utime_; }
  // Behind the last whole message lie this many bytes: of a message that is cut, or damaged.
  std::uint64_t unread_bytes() const { return log_.unread_bytes(); }
  // What of the log is not used, in words (EventLogReader); empty: nothing.
  std::string left_out() const { return log_.truncated() ? log_.left_out() : std::string(); }

  // How many messages have a time before that of the message ahead of them, which they are given: no lab writes so.
  std::size_t moved() const { return moved_; }

  // The bytes of a message, valid until the next call; empty when the file no longer holds it.
  std::span<const std::byte> read(const Entry& entry) const;
  // Takes what a run that goes on has written since. True when there was something.
  bool refresh();
  // Whether the index came from log.index as it was.
  bool index_was_there() const { return index_was_there_; }

 private:
  std::optional<hal::EventView> view(const Entry& entry) const;
  bool load_index();
  void save_index() const;
  void scan();
  void add(const Entry& entry);
  void set_times();

  std::filesystem::path file_;
  mutable hal::EventLogReader log_;  // what read() shows is its memory; stands behind the last whole event
  std::vector<std::string> channels_;
  std::vector<Entry> entries_;
  std::vector<std::int64_t> utimes_;  // of entries_, as in the log
  std::vector<std::vector<std::uint32_t>> by_channel_;
  std::int64_t start_utime_ = 0;
  bool has_start_ = false;
  std::size_t moved_ = 0;
  bool index_was_there_ = false;
};

}  // namespace arkmesh::recording
