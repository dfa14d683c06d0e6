// Arbitrary datagrams of arbitrary senders at arbitrary times. Nothing may crash, unfinished messages stay within their
// bounds, and a message holds no byte that nobody sent.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "hal/bus/datagram_assembler.hpp"
#include "tests/support/network/lcm_datagrams.hpp"

namespace {

using arkmesh::hal::DatagramAssembler;

constexpr DatagramAssembler::Limits limits{.bytes = 3000, .bytes_of_source = 2000, .messages = 5};
constexpr char said = 'B';  // all that senders of fragments say: another byte in a message is a hole

void require(bool condition) {
  if (!condition) std::abort();
}

// The first `count` bytes as a number; 0 when there are not as many.
std::uint32_t take(std::span<const std::byte>& input, std::size_t count) {
  if (input.size() < count) return input = {}, 0;
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < count; ++i) number = number << 8 | static_cast<std::uint32_t>(input[i]);
  input = input.subspan(count);
  return number;
}

// The next datagram: bytes as they are, or a fragment with arbitrary numbers.
std::vector<std::byte> next_datagram(std::span<const std::byte>& input, bool raw) {
  if (raw) {
    const auto bytes = input.first(std::min<std::size_t>(take(input, 1), input.size()));
    input = input.subspan(bytes.size());
    return {bytes.begin(), bytes.end()};
  }
  const std::uint32_t about = take(input, 2);
  arkmesh::tests::Fragment fragment{.channel = "c", .sequence = about % 4, .bytes = {}};
  fragment.number = static_cast<std::uint16_t>(about >> 2 & 7);
  fragment.count = static_cast<std::uint16_t>(about >> 5 & 7);
  fragment.size = take(input, 2) % 2200;
  fragment.offset = about >> 8 & 1 ? take(input, 4) : take(input, 2) % 2200;
  fragment.bytes.assign(take(input, 2) % 2200, said);
  return arkmesh::tests::fragment(fragment);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span input(reinterpret_cast<const std::byte*>(data), size);
  DatagramAssembler assembler(limits);
  DatagramAssembler::TimePoint now{};
  while (!input.empty()) {
    const std::uint32_t about = take(input, 1);
    const bool raw = about & 1;
    const DatagramAssembler::Source from{about >> 1 & 3, static_cast<std::uint16_t>(raw)};
    now += std::chrono::milliseconds(about >> 3);
    const auto datagram = next_datagram(input, raw);
    if (const auto message = assembler.add(from, datagram, now)) {
      require(!message->channel.empty() && message->channel.size() <= 63);
      require(message->bytes.size() <= std::max(limits.bytes_of_source, datagram.size()));
      if (!raw) require(std::ranges::all_of(message->bytes, [](std::byte b) { return b == std::byte{said}; }));
    }
    require(assembler.held_bytes() <= limits.bytes && assembler.unfinished() <= limits.messages);
  }
  return 0;
}
