// LCM's datagrams, all numbers big-endian. LC02: magic and sequence (4 bytes each), channel, 0, bytes. LC03: magic,
// sequence, size of the message, offset of the fragment (4 bytes each), number of the fragment, number of fragments
// (2 each); then, in fragment 0 only, channel and 0; then the fragment's bytes.
#include "hal/bus/datagram_assembler.hpp"

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <utility>

#include "hal/label.hpp"

namespace arkmesh::hal {

namespace {

constexpr std::uint32_t short_magic = 0x4c433032, long_magic = 0x4c433033;  // "LC02", "LC03"
constexpr std::size_t short_header = 8, long_header = 20;
constexpr std::size_t max_channel = 63;
constexpr std::size_t max_ranges = 64;  // a network that reorders delivers a message's fragments in few pieces

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
  return boost::endian::load_big_u32(reinterpret_cast<const unsigned char*>(bytes.data()) + at);
}
std::uint16_t read_u16(std::span<const std::byte> bytes, std::size_t at) {
  return boost::endian::load_big_u16(reinterpret_cast<const unsigned char*>(bytes.data()) + at);
}

// Takes a channel and the zero behind it from the front of `bytes`. Empty when there is none that LCM allows.
std::string_view take_channel(std::span<const std::byte>& bytes) {
  const auto end = std::ranges::find(bytes, std::byte{0});
  const auto length = static_cast<std::size_t>(end - bytes.begin());
  const std::string_view channel(reinterpret_cast<const char*>(bytes.data()), length);
  if (end == bytes.end() || length > max_channel || !std::ranges::all_of(channel, is_printable)) return {};
  bytes = bytes.subspan(length + 1);
  return channel;
}

}  // namespace

std::optional<DatagramAssembler::Message> DatagramAssembler::add(const Source& from,
                                                                 std::span<const std::byte> datagram, TimePoint now) {
  finished_.reset();
  expire(now);
  if (datagram.size() < short_header) return refuse("refused.not_lcm");
  const std::uint32_t magic = read_u32(datagram, 0);
  if (magic == long_magic && datagram.size() >= long_header) return add_fragment(from, datagram, now);
  if (magic != short_magic) return refuse("refused.not_lcm");
  auto bytes = datagram.subspan(short_header);
  const std::string_view channel = take_channel(bytes);
  if (channel.empty()) return refuse("refused.bad_channel_name");
  return Message{channel, bytes};
}

std::optional<DatagramAssembler::Message> DatagramAssembler::add_fragment(const Source& from,
                                                                          std::span<const std::byte> datagram,
                                                                          TimePoint now) {
  const std::uint32_t sequence = read_u32(datagram, 4);
  const std::uint64_t size = read_u32(datagram, 8), offset = read_u32(datagram, 12);
  const std::uint16_t number = read_u16(datagram, 16), count = read_u16(datagram, 18);
  auto bytes = datagram.subspan(long_header);
  if (size > limits_.bytes_of_source || size > limits_.bytes) return refuse("refused.too_long");
  std::string_view channel;
  if (number == 0 && (channel = take_channel(bytes)).empty()) return refuse("refused.bad_channel_name");
  if (number >= count || bytes.empty() || offset + bytes.size() > size) return refuse("refused.bad_fragment");

  auto message = find(from, sequence);
  if (message != unfinished_.end() && message->size != size) {  // the source has begun to count anew
    counters_.add("lost.fragments_missing");
    unfinished_.erase(message);
    message = unfinished_.end();
  }
  if (message == unfinished_.end()) message = begin(from, sequence, size, now);

  switch (message->arrive({offset, offset + bytes.size()})) {
    case Unfinished::Arrival::added:
      std::ranges::copy(bytes, message->bytes.get() + offset);
      break;
    case Unfinished::Arrival::repeated:
      counters_.add("repeated.fragment");
      break;
    case Unfinished::Arrival::overlapping:
      unfinished_.erase(message);
      return refuse("refused.overlapping_fragments");
    case Unfinished::Arrival::scattered:
      unfinished_.erase(message);
      return refuse("refused.scattered_fragments");
  }
  if (message->channel.empty()) message->channel = channel;
  if (!message->complete()) return {};
  finished_ = std::move(*message);
  unfinished_.erase(message);
  return Message{finished_->channel, {finished_->bytes.get(), finished_->size}};
}

// Merges the range with those that it touches.
DatagramAssembler::Unfinished::Arrival DatagramAssembler::Unfinished::arrive(Range range) {
  const auto next = std::ranges::find_if(arrived, [&](const Range& r) { return r.end > range.begin; });
  if (next != arrived.end() && next->begin < range.end)
    return next->begin <= range.begin && range.end <= next->end ? Arrival::repeated : Arrival::overlapping;
  const bool touches_previous = next != arrived.begin() && std::prev(next)->end == range.begin;
  const bool touches_next = next != arrived.end() && next->begin == range.end;
  if (touches_previous && touches_next) {
    std::prev(next)->end = next->end;
    arrived.erase(next);
  } else if (touches_previous) {
    std::prev(next)->end = range.end;
  } else if (touches_next) {
    next->begin = range.begin;
  } else if (arrived.size() == max_ranges) {
    return Arrival::scattered;
  } else {
    arrived.insert(next, range);
  }
  return Arrival::added;
}

DatagramAssembler::Place DatagramAssembler::find(const Source& from, std::uint32_t sequence) {
  return std::ranges::find_if(unfinished_,
                              [&](const Unfinished& u) { return u.sequence == sequence && u.from == from; });
}

// Makes room: first the source's own older messages go, then the oldest of all. A sender sends one message after
// another, so its older ones hardly ever come to an end.
DatagramAssembler::Place DatagramAssembler::begin(const Source& from, std::uint32_t sequence, std::size_t size,
                                                  TimePoint now) {
  const auto drop = [&](Place place) {
    counters_.add("dropped.too_many_unfinished");
    unfinished_.erase(place);
  };
  const auto is_own = [&](const Unfinished& u) { return u.from == from; };
  std::size_t own = 0;
  for (const Unfinished& u : unfinished_) own += is_own(u) ? u.size : 0;
  while (own + size > limits_.bytes_of_source) {
    const auto oldest = std::ranges::find_if(unfinished_, is_own);
    own -= oldest->size;
    drop(oldest);
  }
  while (unfinished_.size() >= limits_.messages || held_bytes() + size > limits_.bytes) drop(unfinished_.begin());
  // Memory that is not touched costs nothing: only bytes that come are written.
  unfinished_.push_back({from, sequence, now, size, std::make_unique_for_overwrite<std::byte[]>(size)});
  return std::prev(unfinished_.end());
}

void DatagramAssembler::expire(TimePoint now) {
  const auto fresh =
      std::ranges::find_if(unfinished_, [&](const Unfinished& u) { return now - u.begun < limits_.patience; });
  if (fresh == unfinished_.begin()) return;
  counters_.add("lost.fragments_missing", static_cast<std::uint64_t>(fresh - unfinished_.begin()));
  unfinished_.erase(unfinished_.begin(), fresh);
}

std::size_t DatagramAssembler::held_bytes() const {
  std::size_t total = 0;
  for (const Unfinished& u : unfinished_) total += u.size;
  return total;
}

std::optional<DatagramAssembler::Message> DatagramAssembler::refuse(std::string_view counter) {
  counters_.add(counter);
  return {};
}

}  // namespace arkmesh::hal
