// An LCM log is a row of events, each: sync word, number, time, channel length, data length (big-endian), channel,
// data.
#include "hal/event_log.hpp"

#include <fmt/format.h>

#include <boost/endian/conversion.hpp>
#include <stdexcept>

namespace arkmesh::hal {

namespace {

constexpr std::uint32_t sync_word = 0xEDA1DA01;
constexpr std::uint32_t max_channel_bytes = 255, max_data_bytes = 64 << 20;
constexpr std::int64_t max_utime = 1'000'000'000'000'000'000;  // the year 30000: times that can be reckoned with

// The fields of a header, at their places.
unsigned char* at(EventHeader::Bytes& bytes, std::size_t place) {
  return reinterpret_cast<unsigned char*>(bytes.data() + place);
}
const unsigned char* at(const EventHeader::Bytes& bytes, std::size_t place) {
  return reinterpret_cast<const unsigned char*>(bytes.data() + place);
}

}  // namespace

bool EventHeader::begins(const Bytes& bytes) {
  return boost::endian::load_big_u32(at(bytes, 0)) == sync_word;
}

std::optional<EventHeader> EventHeader::from(const Bytes& bytes) {
  const EventHeader out{boost::endian::load_big_s64(at(bytes, 4)), boost::endian::load_big_s64(at(bytes, 12)),
                        boost::endian::load_big_u32(at(bytes, 20)), boost::endian::load_big_u32(at(bytes, 24))};
  if (!begins(bytes) || out.channel_bytes > max_channel_bytes || out.data_bytes > max_data_bytes ||
      out.utime < -max_utime || out.utime > max_utime)
    return {};
  return out;
}

EventHeader::Bytes EventHeader::bytes() const {
  Bytes out{};
  boost::endian::store_big_u32(at(out, 0), sync_word);
  boost::endian::store_big_s64(at(out, 4), number);
  boost::endian::store_big_s64(at(out, 12), utime);
  boost::endian::store_big_u32(at(out, 20), channel_bytes);
  boost::endian::store_big_u32(at(out, 24), data_bytes);
  return out;
}

EventLogReader::EventLogReader(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw std::runtime_error(fmt::format("there is no file {}", file.string()));
  if (!std::filesystem::is_regular_file(status)) throw std::runtime_error(fmt::format("{} is no file", file.string()));
  in_.open(file, std::ios::binary);
  if (!in_) throw std::runtime_error(fmt::format("{} cannot be read; check its permissions", file.string()));
  EventHeader::Bytes first{};
  in_.read(reinterpret_cast<char*>(first.data()), 4);
  if (in_.gcount() == 0) throw std::runtime_error(fmt::format("{} is empty", file.string()));
  if (!EventHeader::begins(first)) throw std::runtime_error(fmt::format("{} is no LCM log", file.string()));
  in_.seekg(0);
}

std::optional<LogEvent> EventLogReader::next() {
  if (truncated_) return {};
  EventHeader::Bytes bytes{};
  in_.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
  if (in_.gcount() == 0) return {};
  truncated_ = true;  // unless the event turns out whole
  const auto header = in_ ? EventHeader::from(bytes) : std::nullopt;
  if (!header) return {};

  LogEvent out;
  out.number = header->number;
  out.utime = header->utime;
  out.channel.resize(header->channel_bytes);
  in_.read(out.channel.data(), static_cast<std::streamsize>(out.channel.size()));
  if (!in_) return {};
  out.bytes.resize(header->data_bytes);
  in_.read(reinterpret_cast<char*>(out.bytes.data()), static_cast<std::streamsize>(out.bytes.size()));
  if (!in_) return {};
  truncated_ = false;
  return out;
}

}  // namespace arkmesh::hal
