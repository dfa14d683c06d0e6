// An LCM log is a row of events, each: sync word, number, time, channel length, data length (big-endian), channel,
// data.
#include "hal/record/event_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "hal/counted.hpp"

namespace arkmesh::hal {
namespace {

namespace endian = boost::endian;

constexpr std::uint32_t sync_word = 0xEDA1DA01;
constexpr std::array sync{std::byte{0xED}, std::byte{0xA1}, std::byte{0xDA}, std::byte{0x01}};
constexpr std::uint32_t max_channel_bytes = 255, max_data_bytes = 64 << 20;
constexpr std::size_t header_bytes = sizeof(EventHeader::Bytes), read_ahead_bytes = 1 << 16;
constexpr std::int64_t max_utime = 1'000'000'000'000'000'000;  // the year 30000: times that can be reckoned with

// Nothing when the bytes begin with no header, or one that is not sane.
std::optional<EventHeader> header_of(std::span<const std::byte> bytes) {
  if (bytes.size() < header_bytes) return {};
  const auto* const at = reinterpret_cast<const unsigned char*>(bytes.data());
  const EventHeader out{endian::load_big_s64(at + 4), endian::load_big_s64(at + 12), endian::load_big_u32(at + 20),
                        endian::load_big_u32(at + 24)};
  if (endian::load_big_u32(at) != sync_word || !out.is_sane()) return {};
  return out;
}

// Its data as far as they are there; nothing when the channel is not.
std::optional<EventView> view_of(std::span<const std::byte> bytes) {
  const auto header = header_of(bytes);
  if (!header || bytes.size() < header_bytes + header->channel_bytes) return {};
  const auto rest = bytes.subspan(header_bytes);
  return EventView{*header,
                   {reinterpret_cast<const char*>(rest.data()), header->channel_bytes},
                   rest.subspan(header->channel_bytes)};
}

}  // namespace

std::filesystem::path log_in(const std::filesystem::path& folder) {
  std::error_code error;
  const bool is_packed = !std::filesystem::exists(folder / log_name, error) &&
                         std::filesystem::is_regular_file(folder / packed_log_name, error);
  return folder / (is_packed ? packed_log_name : log_name);
}

bool EventHeader::is_sane() const {
  return channel_bytes >= 1 && channel_bytes <= max_channel_bytes && data_bytes <= max_data_bytes &&
         utime >= -max_utime && utime <= max_utime;
}

EventHeader::Bytes EventHeader::encoded() const {
  Bytes out{};
  auto* const at = reinterpret_cast<unsigned char*>(out.data());
  endian::store_big_u32(at, sync_word);
  endian::store_big_s64(at + 4, number);
  endian::store_big_s64(at + 12, utime);
  endian::store_big_u32(at + 20, channel_bytes);
  endian::store_big_u32(at + 24, data_bytes);
  return out;
}

EventLogReader::EventLogReader(const std::filesystem::path& file)
    : file_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (!file_)
    throw std::runtime_error(errno == ENOENT
                                 ? fmt::format("there is no file {}", file.string())
                                 : fmt::format("{} cannot be read: {}", file.string(), std::strerror(errno)));
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0 || !S_ISREG(status.st_mode))
    throw std::runtime_error(fmt::format("{} is not a file", file.string()));
  std::array<std::byte, 4> begin{};
  if (PackedFile::is_one(std::span(begin).first(read_file_at(file_.get(), 0, begin)))) packed_.emplace(file_.get());
  look_again();
  if (packed_ && packed_->is_foreign())
    throw std::runtime_error(
        fmt::format("{0} has a zstd frame that is too large or lacks its size, so no lab wrote it; unpack it with "
                    "`zstd -d {0}` and give the result",
                    file.string()));
  const auto first = bytes_at(0, sync.size());
  if (size_ > 0 && !std::ranges::equal(first, sync) && !find_event(0, size_))
    throw std::runtime_error(fmt::format("{} is not an LCM log", file.string()));
}

void EventLogReader::look_again() {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) return;
  auto size = static_cast<std::uint64_t>(status.st_size);
  if (packed_) {
    packed_->look_again(size);
    size = packed_->size();
  }
  size_ = std::max(end_, size);
}

std::size_t EventLogReader::read(std::uint64_t offset, std::span<std::byte> to) {
  return packed_ ? packed_->read(offset, to) : read_file_at(file_.get(), offset, to);
}

std::span<const std::byte> EventLogReader::bytes_at(std::uint64_t offset, std::size_t n) {
  if (offset < ahead_begin_ || offset + n > ahead_begin_ + ahead_.size()) {
    ahead_begin_ = offset;
    ahead_.resize(std::max(n, read_ahead_bytes));
    ahead_.resize(read(offset, ahead_));
  }
  const std::span<const std::byte> rest = std::span(ahead_).subspan(offset - ahead_begin_);
  return rest.first(std::min(n, rest.size()));
}

bool EventLogReader::is_whole(std::uint64_t place, const EventHeader& header) {
  if (place + header.size() > size_) return false;
  const auto event = view_of(bytes_at(place, header_bytes + header.channel_bytes));
  return event && std::ranges::all_of(event->channel, [](char c) { return static_cast<unsigned char>(c) >= ' '; });
}

bool EventLogReader::ends_at(std::uint64_t place) {
  std::array<std::byte, sync.size()> next{};
  const std::size_t n = read(place, next);
  return place == size_ || (n > 0 && std::ranges::equal(std::span(next).first(n), std::span(sync).first(n)));
}

std::optional<std::uint64_t> EventLogReader::find_event(std::uint64_t from, std::uint64_t to) {
  while (from + header_bytes <= to) {
    const auto bytes = bytes_at(from, std::min<std::uint64_t>(read_ahead_bytes, size_ - from));
    if (bytes.size() < header_bytes) return {};
    const auto at = std::search(bytes.begin(), bytes.end(), sync.begin(), sync.end());
    from += static_cast<std::uint64_t>(at - bytes.begin());
    if (at == bytes.end()) {
      from -= sync.size() - 1;  // one may begin there
      continue;
    }
    if (from >= to) return {};
    const auto header = header_of(bytes_at(from, header_bytes));
    if (const std::uint64_t end = from + (header ? header->size() : 0);
        header && is_whole(from, *header) && ends_at(end))
      return from;
    ++from;
  }
  return {};
}

std::optional<EventView> EventLogReader::next_place() {
  auto header = header_of(bytes_at(end_, header_bytes));
  // One that no other follows is damaged if another one begins within; else what is behind it is.
  if (!header || end_ + header->size() > size_ || !ends_at(end_ + header->size())) {
    const bool fits = header && is_whole(end_, *header);
    const auto place = find_event(end_ + 1, fits ? end_ + header->size() : size_);
    if (!place && !fits) return {};
    if (place) {
      skipped_ += *place - end_;
      ++gaps_;
      end_ = *place;
      header = header_of(bytes_at(end_, header_bytes));
      if (!header) return {};  // the file was changed meanwhile
    }
  }
  const auto out = view_of(bytes_at(end_, header->size() - header->data_bytes));
  if (out) end_ += header->size();
  return out;
}

std::optional<EventView> EventLogReader::next() {
  const auto place = next_place();
  if (!place) return {};
  const std::uint64_t begin = end_ - place->size();
  const auto event = view_of(bytes_at(begin, end_ - begin));
  if (event && event->bytes.size() == event->data_bytes) return event;
  end_ = begin;  // the file was cut meanwhile
  return {};
}

std::string EventLogReader::left_out() const {
  const std::string tail = fmt::format("its last {}", counted(unread_bytes(), "byte is", "bytes are"));
  if (skipped_bytes() == 0) return tail;
  return fmt::format("{} in {}{}", counted(skipped_bytes(), "byte"),
                     counted(gaps_ + (packed_ ? packed_->gaps() : 0), "place"),
                     unread_bytes() > 0 ? " and " + tail : " are");
}

std::optional<EventView> EventLogReader::read_at(std::uint64_t offset, std::size_t size) {
  event_.resize(size);
  if (read(offset, event_) < size) return {};
  const auto out = view_of(event_);
  return out && out->size() == size ? out : std::nullopt;
}

}  // namespace arkmesh::hal
