// Reads no more of these messages than who sent them; a foreign message may be of another version.
#include "hal/neighbour_detector.hpp"

#include <boost/endian/conversion.hpp>
#include <optional>
#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/messages.hpp"

namespace arkmesh::hal {
namespace {

// The first two fields of lab_status_t and of peers_t: fingerprint, text with its length, 64-bit number.
std::optional<Talker> read_talker(std::span<const std::byte> bytes, std::int64_t fingerprint) {
  const auto* at = reinterpret_cast<const unsigned char*>(bytes.data());
  if (bytes.size() < 12 || boost::endian::load_big_s64(at) != fingerprint) return {};
  const std::uint32_t length = boost::endian::load_big_u32(at + 8);  // counts the final zero
  if (length < 2 || length > max_lab_name + 1 || bytes.size() < 12 + length + 8) return {};
  Talker talker{.lab = {reinterpret_cast<const char*>(at) + 12, length - 1},
                .number = boost::endian::load_big_u64(at + 12 + length)};
  if (!is_lab_name(talker.lab)) return {};
  return talker;
}

}  // namespace

NeighbourDetector::NeighbourDetector(Bus& bus, std::function<void(const Talker&)> heard)
    : bus_(bus),
      heard_(std::move(heard)),
      status_(bus.subscribe(channel::status,
                            [this](std::string_view, auto bytes) { hear(false, lab_status_t::getHash(), bytes); })),
      peers_(bus.subscribe(channel::peers,
                           [this](std::string_view, auto bytes) { hear(true, peers_t::getHash(), bytes); })) {}

void NeighbourDetector::hear(bool is_gateway, std::int64_t fingerprint, std::span<const std::byte> bytes) {
  auto talker = read_talker(bytes, fingerprint);
  if (!talker) return counters_.add(is_gateway ? "bus.ignored.peers" : "bus.ignored.status");
  talker->is_gateway = is_gateway;
  heard_(*talker);
}

void NeighbourDetector::listen(std::chrono::milliseconds time, const std::function<bool()>& enough) {
  const auto until = std::chrono::steady_clock::now() + time;
  for (auto now = until - time; now < until && !enough(); now = std::chrono::steady_clock::now())
    bus_.drain(std::chrono::ceil<std::chrono::milliseconds>(until - now));
}

}  // namespace arkmesh::hal
