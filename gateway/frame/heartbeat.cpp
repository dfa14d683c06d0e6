// Both are big-endian words of 8 bytes, in the order of their members.
#include "gateway/frame/heartbeat.hpp"

#include <array>
#include <boost/endian/conversion.hpp>

namespace arkmesh::gateway {
namespace {

// No clock goes further, and none of them overflows when two are added.
constexpr std::int64_t latest_us = std::int64_t{1} << 60;

template <std::size_t n>
std::vector<std::byte> encode_words(const std::array<std::uint64_t, n>& words) {
  std::vector<std::byte> out(8 * n);
  for (std::size_t i = 0; i < n; ++i)
    boost::endian::store_big_u64(reinterpret_cast<unsigned char*>(out.data() + 8 * i), words[i]);
  return out;
}

template <std::size_t n>
std::optional<std::array<std::uint64_t, n>> read_words(std::span<const std::byte> payload) {
  if (payload.size() != 8 * n) return {};
  std::array<std::uint64_t, n> words;
  for (std::size_t i = 0; i < n; ++i)
    words[i] = boost::endian::load_big_u64(reinterpret_cast<const unsigned char*>(payload.data() + 8 * i));
  return words;
}

std::uint64_t word(std::int64_t value) {
  return static_cast<std::uint64_t>(value);
}
std::int64_t number(std::uint64_t word) {
  return static_cast<std::int64_t>(word);
}

}  // namespace

std::vector<std::byte> encode(const Acknowledgement& received) {
  return encode_words<2>({received.messages, received.bytes});
}

std::vector<std::byte> encode(const Heartbeat& h) {
  return encode_words<8>({h.received.messages, h.received.bytes, h.ordered_accepted, h.ordered_pending, word(h.time_us),
                          word(h.wall_us), word(h.echo_us), word(h.held_us)});
}

std::optional<Acknowledgement> read_acknowledgement(std::span<const std::byte> payload) {
  const auto words = read_words<2>(payload);
  if (!words) return {};
  return Acknowledgement{(*words)[0], (*words)[1]};
}

std::optional<Heartbeat> read_heartbeat(std::span<const std::byte> payload) {
  const auto words = read_words<8>(payload);
  if (!words) return {};
  const auto& w = *words;
  for (std::size_t i = 4; i < w.size(); ++i)
    if (number(w[i]) > latest_us || number(w[i]) < -latest_us) return {};
  return Heartbeat{.received = {w[0], w[1]},
                   .ordered_accepted = w[2],
                   .ordered_pending = w[3],
                   .time_us = number(w[4]),
                   .wall_us = number(w[5]),
                   .echo_us = number(w[6]),
                   .held_us = number(w[7])};
}

}  // namespace arkmesh::gateway
