// log.index, little-endian: "ARKIDX01", bytes of the log that it covers (8), channels (4), events (4); each channel:
// length (1), name; each event: microseconds since 1970 (8), offset in the log (8), bytes of the message (4), channel
// (2), zeros (2); CRC-32 of all before (4).
#include "recording/log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>

#include "hal/event_log.hpp"
#include "hal/replace_file.hpp"
#include "recording/message.hpp"

namespace arkmesh::recording {
namespace {

constexpr std::size_t header_bytes = sizeof(hal::EventHeader::Bytes), event_bytes = 24;
constexpr std::size_t max_channels = 4096, max_events = 100'000'000;
constexpr std::string_view magic = "ARKIDX01";
constexpr std::size_t max_looked_at = 100;  // messages, for their lab time
// Messages whose first field is their lab time, which thus tell what lab time 0 stands for.
constexpr std::string_view stamped[] = {"poses", "shared", "overlay"};

// As many bytes as there are, up to the span's size.
std::size_t read_at(int descriptor, std::uint64_t offset, std::span<std::byte> to) {
  std::size_t done = 0;
  while (done < to.size()) {
    const ssize_t n = ::pread(descriptor, to.data() + done, to.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

// Of at least header_bytes.
std::optional<hal::EventHeader> header_of(std::span<const std::byte> bytes) {
  hal::EventHeader::Bytes out;
  std::ranges::copy(bytes.first(header_bytes), out.begin());
  return hal::EventHeader::from(out);
}

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

std::uint64_t size_of(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) ? static_cast<std::uint64_t>(status.st_size) : 0;
}

std::filesystem::path index_file(const std::filesystem::path& log) {
  return std::filesystem::path(log).replace_extension(".index");
}

}  // namespace

Log::Log(const std::filesystem::path& file)
    : file_(file), descriptor_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (descriptor_ < 0)
    throw std::runtime_error(errno == ENOENT
                                 ? fmt::format("there is no file {}", file.string())
                                 : fmt::format("{} cannot be read: {}", file.string(), std::strerror(errno)));
  size_ = size_of(descriptor_);
  hal::EventHeader::Bytes first{};
  if (size_ > 0 && (read_at(descriptor_, 0, first) < 4 || !hal::EventHeader::begins(first))) {
    ::close(descriptor_);
    throw std::runtime_error(fmt::format("{} is no LCM log", file.string()));
  }
  index_was_there_ = load_index();
  const std::size_t known = entries_.size();
  scan();
  set_times();
  if (entries_.size() > known || !index_was_there_) save_index();
}

Log::~Log() {
  if (descriptor_ >= 0) ::close(descriptor_);
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

std::span<const std::byte> Log::read(const Entry& entry) const {
  const std::string& channel = channels_[entry.channel];
  buffer_.resize(header_bytes + channel.size() + entry.bytes);
  if (read_at(descriptor_, entry.offset, buffer_) < buffer_.size()) return {};
  const auto header = header_of(buffer_);
  if (!header || header->channel_bytes != channel.size() || header->data_bytes != entry.bytes ||
      std::memcmp(buffer_.data() + header_bytes, channel.data(), channel.size()) != 0)
    return {};
  return std::span<const std::byte>(buffer_).subspan(header_bytes + channel.size());
}

bool Log::refresh() {
  const std::size_t before = entries_.size();
  size_ = size_of(descriptor_);
  scan();
  set_times();
  return entries_.size() > before;
}

// From the end of what is known to the first event that is not whole.
void Log::scan() {
  std::map<std::string, std::uint16_t, std::less<>> numbers;
  for (std::size_t i = 0; i < channels_.size(); ++i) numbers.emplace(channels_[i], static_cast<std::uint16_t>(i));
  std::vector<std::byte> block(1 << 20);
  std::uint64_t block_begin = 0;
  std::size_t block_size = 0;
  // Bytes of the file from `offset` on; nullptr: they are not all there.
  const auto bytes_at = [&](std::uint64_t offset, std::size_t n) -> const std::byte* {
    if (offset < block_begin || offset + n > block_begin + block_size) {
      block_begin = offset;
      block_size = read_at(descriptor_, offset, block);
      if (n > block_size) return nullptr;
    }
    return block.data() + (offset - block_begin);
  };
  while (end_ + header_bytes <= size_ && entries_.size() < max_events) {
    const std::byte* const begin = bytes_at(end_, header_bytes);
    if (!begin) break;
    const auto header = header_of({begin, header_bytes});
    if (!header || end_ + header_bytes + header->channel_bytes + header->data_bytes > size_) break;
    const std::byte* const name = bytes_at(end_ + header_bytes, header->channel_bytes);
    if (!name) break;
    const std::string_view channel(reinterpret_cast<const char*>(name), header->channel_bytes);
    auto number = numbers.find(channel);
    if (number == numbers.end()) {
      if (channels_.size() == max_channels) break;
      number = numbers.emplace(channel, static_cast<std::uint16_t>(channels_.size())).first;
      channels_.emplace_back(channel);
    }
    utimes_.push_back(header->utime);
    add({0, end_, header->data_bytes, number->second});
    end_ += header_bytes + header->channel_bytes + header->data_bytes;
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
      const auto stamp = static_cast<std::int64_t>(big_endian(message.subspan(8, 8)));
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
  const int descriptor = ::open(index_file(file_).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return false;
  const std::uint64_t size = size_of(descriptor);
  // every event takes more in the log than here, but for a few bytes of the index itself
  std::vector<std::byte> all(size <= size_ + (1 << 20) ? size : 0);
  const bool is_read = !all.empty() && read_at(descriptor, 0, all) == all.size();
  ::close(descriptor);
  if (!is_read || all.size() < 28) return false;
  const std::span<const std::byte> bytes(all);
  if (std::memcmp(all.data(), magic.data(), magic.size()) != 0 ||
      crc_of(bytes.first(all.size() - 4)) != little_endian(bytes.last(4)))
    return false;
  const std::uint64_t covered = little_endian(bytes.subspan(8, 8));
  const std::uint64_t n_channels = little_endian(bytes.subspan(16, 4)), n_events = little_endian(bytes.subspan(20, 4));
  if (covered > size_ || n_channels > max_channels || n_events > max_events) return false;
  std::vector<std::string> channels;
  std::size_t at = 24;
  for (std::uint64_t i = 0; i < n_channels; ++i) {
    const std::size_t length = at < all.size() ? std::to_integer<std::size_t>(all[at]) : all.size();
    if (at + 1 + length > all.size()) return false;
    channels.emplace_back(reinterpret_cast<const char*>(all.data() + at + 1), length);
    at += 1 + length;
  }
  if (all.size() - at != n_events * event_bytes + 4) return false;

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
    const std::string& channel = channels[entry.channel];
    if (!header_of(hal::EventHeader{0, utimes.back(), static_cast<std::uint32_t>(channel.size()), entry.bytes}.bytes()))
      return false;
    end += header_bytes + channel.size() + entry.bytes;
  }
  if (end != covered) return false;
  // An index of another log, as after a copy: the first event of each channel and the last of all tell.
  const auto is_there = [&](std::size_t i) {
    const std::string& channel = channels[entries[i].channel];
    std::vector<std::byte> begin(header_bytes + channel.size());
    if (read_at(descriptor_, entries[i].offset, begin) < begin.size()) return false;
    const auto header = header_of(begin);
    return header && header->utime == utimes[i] && header->data_bytes == entries[i].bytes &&
           header->channel_bytes == channel.size() &&
           std::memcmp(begin.data() + header_bytes, channel.data(), channel.size()) == 0;
  };
  std::vector<bool> has_events(channels.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const bool is_first = !has_events[entries[i].channel];
    has_events[entries[i].channel] = true;
    if ((is_first || i + 1 == entries.size()) && !is_there(i)) return false;
  }
  if (std::ranges::find(has_events, false) != has_events.end()) return false;
  channels_ = std::move(channels);
  utimes_ = std::move(utimes);
  for (const Entry& entry : entries) add(entry);
  by_channel_.resize(channels_.size());
  end_ = covered;
  return true;
}

// Where it cannot be written, as on a medium for reading only, the next reader makes it again.
void Log::save_index() const {
  std::string out(magic);
  put(out, end_, 8);
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
