// log.index, little-endian: "ARKIDX01", bytes of the log that it covers (8), channels (4), events (4); each channel:
// length (1), name; each event: microseconds since 1970 (8), offset in the log (8), bytes of the message (4), channel
// (2), zeros (2); CRC-32 of all before (4).
#include "recording/log.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <map>

#include "hal/files/replace_file.hpp"
#include "hal/files/whole_file.hpp"
#include "hal/layout/message.hpp"

namespace arkmesh::recording {
namespace {

constexpr std::size_t header_bytes = sizeof(hal::EventHeader::Bytes), event_bytes = 24;
constexpr std::size_t max_channels = 4096, max_events = 100'000'000;
constexpr std::string_view magic = "ARKIDX01";
constexpr std::size_t max_looked_at = 100;  // messages, for their lab time
// Messages whose first field is their lab time, which thus tell what lab time 0 stands for.
constexpr std::string_view stamped[] = {"poses", "shared", "overlay"};

void put(std::string& to, std::uint64_t value, int bytes) {
  for (; bytes > 0; --bytes, value >>= 8) to += static_cast<char>(value);
}

std::uint64_t little_endian(std::span<const std::byte> bytes) {
  std::uint64_t out = 0;
  for (std::size_t i = bytes.size(); i > 0; --i) out = out << 8 | std::to_integer<std::uint64_t>(bytes[i - 1]);
  return out;
}

std::uint32_t crc_of(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::filesystem::path index_file(const std::filesystem::path& log) {
  const std::filesystem::path plain = log.extension() == ".zst" ? log.parent_path() / log.stem() : log;
  return std::filesystem::path(plain).replace_extension(".index");
}

}  // namespace

Log::Log(const std::filesystem::path& file) : file_(file), log_(file) {
  index_was_there_ = load_index();
  const std::size_t known = entries_.size();
  scan();
  set_times();
  if (entries_.size() > known || !index_was_there_) save_index();
}

std::optional<std::size_t> Log::find_channel(std::string_view name) const {
  const auto found = std::ranges::find(channels_, name);
  if (found == channels_.end()) return {};
  return static_cast<std::size_t>(found - channels_.begin());
}

std::optional<std::uint32_t> Log::newest(std::size_t channel, std::int64_t t_us) const {
  const auto& all = by_channel_[channel];
  const auto after = std::ranges::upper_bound(all, t_us, {}, [&](std::uint32_t i) { return entries_[i].t_us; });
  if (after == all.begin()) return {};
  return *(after - 1);
}

std::optional<hal::EventView> Log::view(const Entry& entry) const {
  const std::string& channel = channels_[entry.channel];
  const auto event = log_.read_at(entry.offset, header_bytes + channel.size() + entry.bytes);
  return event && event->channel == channel ? event : std::nullopt;
}

std::span<const std::byte> Log::read(const Entry& entry) const {
  const auto event = view(entry);
  return event ? event->bytes : std::span<const std::byte>();
}

bool Log::refresh() {
  const std::size_t before = entries_.size();
  log_.look_again();
  scan();
  set_times();
  return entries_.size() > before;
}

// From the end of what is known to the first event that is not whole.
void Log::scan() {
  std::map<std::string, std::uint16_t, std::less<>> numbers;
  for (std::size_t i = 0; i < channels_.size(); ++i) numbers.emplace(channels_[i], static_cast<std::uint16_t>(i));
  while (entries_.size() < max_events) {
    const auto event = log_.next_place();
    if (!event) break;
    const std::uint64_t offset = log_.place() - event->size();  // damage may lie before it
    auto number = numbers.find(event->channel);
    if (number == numbers.end()) {
      if (channels_.size() == max_channels) return log_.go_to(offset);
      number = numbers.emplace(event->channel, static_cast<std::uint16_t>(channels_.size())).first;
      channels_.emplace_back(event->channel);
    }
    utimes_.push_back(event->utime);
    add({0, offset, event->data_bytes, number->second});
  }
}

void Log::add(const Entry& entry) {
  by_channel_.resize(channels_.size());
  by_channel_[entry.channel].push_back(static_cast<std::uint32_t>(entries_.size()));
  entries_.push_back(entry);
}

// Lab times from the log's: 0 before the robots began to move, and never back, as lab time goes.
void Log::set_times() {
  if (!has_start_ && !utimes_.empty()) start_utime_ = utimes_.front();
  // Before robots begin to move, messages have the time of the wall; the first with a lab time above 0 tells where that
  // began.
  for (const std::string_view name : stamped) {
    const auto channel = has_start_ ? std::nullopt : find_channel(name);
    if (!channel) continue;
    const auto& all = by_channel_[*channel];
    for (std::size_t i = 0; i < std::min(all.size(), max_looked_at) && !has_start_; ++i) {
      const auto message = read(entries_[all[i]]);
      if (message.size() < 16) continue;
      const auto stamp = static_cast<std::int64_t>(hal::layout::big_endian(message.subspan(8, 8)));
      constexpr std::int64_t max_stamp = 1'000'000'000'000'000;  // 30 years
      if (stamp < 0 || stamp > max_stamp) continue;
      start_utime_ = utimes_[all[i]] - stamp;
      has_start_ = stamp > 0;
    }
  }
  std::int64_t last = 0;
  moved_ = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const std::int64_t t_us = utimes_[i] - start_utime_;
    if (t_us < last && last > 0) ++moved_;
    entries_[i].t_us = last = std::max(last, t_us);
  }
}

bool Log::load_index() {
  // every event takes more in the log than here, but for a few bytes of the index itself
  const auto all = hal::whole_file(index_file(file_), log_.size() + (1 << 20));
  if (!all || all->size() < 28) return false;
  const auto bytes = std::as_bytes(std::span(*all));
  if (!all->starts_with(magic) || crc_of(bytes.first(bytes.size() - 4)) != little_endian(bytes.last(4))) return false;
  const std::uint64_t covered = little_endian(bytes.subspan(8, 8));
  const std::uint64_t n_channels = little_endian(bytes.subspan(16, 4)), n_events = little_endian(bytes.subspan(20, 4));
  if (covered > log_.size() || n_channels > max_channels || n_events > max_events) return false;
  std::vector<std::string> channels;
  std::size_t at = 24;
  for (std::uint64_t i = 0; i < n_channels; ++i) {
    const std::size_t length = at < bytes.size() ? std::to_integer<std::size_t>(bytes[at]) : bytes.size();
    if (at + 1 + length > bytes.size()) return false;
    channels.push_back(all->substr(at + 1, length));
    at += 1 + length;
  }
  if (bytes.size() - at != n_events * event_bytes + 4) return false;

  // Event follows event, without gaps up to what it covers.
  std::uint64_t end = 0;
  std::vector<Entry> entries;
  std::vector<std::int64_t> utimes;
  entries.reserve(n_events);
  utimes.reserve(n_events);
  for (std::uint64_t i = 0; i < n_events; ++i, at += event_bytes) {
    const auto event = bytes.subspan(at, event_bytes);
    utimes.push_back(static_cast<std::int64_t>(little_endian(event.first(8))));
    entries.push_back({0, little_endian(event.subspan(8, 8)),
                       static_cast<std::uint32_t>(little_endian(event.subspan(16, 4))),
                       static_cast<std::uint16_t>(little_endian(event.subspan(20, 2)))});
    const Entry& entry = entries.back();
    if (entry.channel >= channels.size() || entry.offset != end) return false;
    const hal::EventHeader header{0, utimes.back(), static_cast<std::uint32_t>(channels[entry.channel].size()),
                                  entry.bytes};
    if (!header.is_sane()) return false;
    end += header.size();
  }
  if (end != covered) return false;
  channels_ = std::move(channels);
  utimes_ = std::move(utimes);
  for (const Entry& entry : entries) add(entry);
  by_channel_.resize(channels_.size());
  log_.go_to(covered);
  // An index of another log, as after a copy: the first event of each channel and the last of all tell.
  const auto is_there = [this](std::size_t i) {
    const auto event = view(entries_[i]);
    return event && event->utime == utimes_[i];
  };
  if ((entries_.empty() || is_there(entries_.size() - 1)) &&
      std::ranges::all_of(by_channel_, [&](const auto& all_of) { return !all_of.empty() && is_there(all_of.front()); }))
    return true;
  channels_.clear();
  utimes_.clear();
  entries_.clear();
  by_channel_.clear();
  log_.go_to(0);
  return false;
}

// Where it cannot be written, as on a medium for reading only, the next reader makes it again.
void Log::save_index() const {
  std::string out(magic);
  put(out, log_.place(), 8);
  put(out, channels_.size(), 4);
  put(out, entries_.size(), 4);
  for (const std::string& channel : channels_) {
    put(out, channel.size(), 1);
    out += channel;
  }
  out.reserve(out.size() + entries_.size() * event_bytes + 4);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    put(out, static_cast<std::uint64_t>(utimes_[i]), 8);
    put(out, entries_[i].offset, 8);
    put(out, entries_[i].bytes, 4);
    put(out, entries_[i].channel, 2);
    put(out, 0, 2);
  }
  put(out, crc_of(std::as_bytes(std::span(out))), 4);
  hal::replace_file(index_file(file_), out);
}

}  // namespace arkmesh::recording
