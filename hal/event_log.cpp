// An LCM log is a row of events, each: sync word, number, time, channel length, data length (big-endian), channel,
// data.
#include "hal/event_log.hpp"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

namespace arkmesh::hal {

namespace {

constexpr std::uint64_t sync_word = 0xEDA1DA01;
constexpr std::size_t header_bytes = 28;
constexpr std::uint64_t max_channel_bytes = 1024, max_data_bytes = 64 << 20;

std::uint64_t big_endian(const unsigned char* from, int bytes) {
  std::uint64_t out = 0;
  for (int i = 0; i < bytes; ++i) out = out << 8 | from[i];
  return out;
}

}  // namespace

EventLogReader::EventLogReader(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw std::runtime_error(fmt::format("there is no file {}", file.string()));
  if (!std::filesystem::is_regular_file(status)) throw std::runtime_error(fmt::format("{} is no file", file.string()));
  in_.open(file, std::ios::binary);
  if (!in_) throw std::runtime_error(fmt::format("{} cannot be read; check its permissions", file.string()));
  std::array<unsigned char, 4> first{};
  in_.read(reinterpret_cast<char*>(first.data()), first.size());
  if (in_.gcount() == 0) throw std::runtime_error(fmt::format("{} is empty", file.string()));
  if (in_.gcount() < 4 || big_endian(first.data(), 4) != sync_word)
    throw std::runtime_error(fmt::format("{} is no LCM log", file.string()));
  in_.seekg(0);
}

std::optional<LogEvent> EventLogReader::next() {
  if (truncated_) return {};
  std::array<unsigned char, header_bytes> header{};
  in_.read(reinterpret_cast<char*>(header.data()), header.size());
  if (in_.gcount() == 0) return {};
  truncated_ = true;  // unless the event turns out whole
  if (in_.gcount() < static_cast<std::streamsize>(header.size()) || big_endian(header.data(), 4) != sync_word)
    return {};
  const std::uint64_t channel_bytes = big_endian(header.data() + 20, 4), data_bytes = big_endian(header.data() + 24, 4);
  if (channel_bytes > max_channel_bytes || data_bytes > max_data_bytes) return {};

  LogEvent out;
  out.number = static_cast<std::int64_t>(big_endian(header.data() + 4, 8));
  out.utime = static_cast<std::int64_t>(big_endian(header.data() + 12, 8));
  out.channel.resize(channel_bytes);
  in_.read(out.channel.data(), static_cast<std::streamsize>(channel_bytes));
  if (!in_) return {};
  out.bytes.resize(data_bytes);
  in_.read(reinterpret_cast<char*>(out.bytes.data()), static_cast<std::streamsize>(data_bytes));
  if (!in_) return {};
  truncated_ = false;
  return out;
}

}  // namespace arkmesh::hal
