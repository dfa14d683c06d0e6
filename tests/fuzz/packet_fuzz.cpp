// Arbitrary messages and pages to an overhead controller, through a byte stream that takes them in arbitrary pieces and
// is lost at arbitrary moments: the controller hears what was meant and nothing else, and never the same packet twice
// in a row.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/platforms/kilobot/packet_sender.hpp"
#include "tests/support/kilobot/fake_cable.hpp"

namespace {

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace std::chrono_literals;

void require(bool condition) {
  if (!condition) std::abort();
}

// Takes bytes from the input until there are none, then zeros.
class Input {
 public:
  explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool empty() const { return bytes_.empty(); }
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t out = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return out;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

Packet next_packet(Input& input, const std::optional<Packet>& last) {
  const std::uint8_t kind = input.byte() % 8;
  if (kind == 7 && last) return *last;
  Message message;
  if (kind < 4) {
    for (auto& byte : message.data) byte = input.byte();
    message.type = input.byte();
    message.crc = static_cast<std::uint16_t>(input.byte() << 8 | input.byte());
  }
  std::array<std::uint8_t, page_bytes> page{};
  switch (kind) {
    case 0:
    case 1:
      return forward_packet(message);
    case 2:
      return forward_once_packet(message);
    case 3:
      return forward_raw_packet(message);
    case 4:
    case 5: {
      // a page from a few bytes over and over, so that it need not be long to be dangerous
      const std::uint8_t number = input.byte();
      const std::array<std::uint8_t, 4> pattern{input.byte(), input.byte(), input.byte(), input.byte()};
      for (std::size_t i = 0; i < page.size(); ++i) page[i] = pattern[i % 4];
      return boot_page_packet(number, page);
    }
    default:
      return led_toggle_packet();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input input({data, size});

  // any bytes at all, to the ear and to the check
  tests::PacketEar ear;
  for (const Packet& packet : ear.hear({data, size}))
    require(is_packet(packet) && packet_checksum(packet) == packet[packet_bytes - 1]);

  auto cable = std::make_shared<tests::FakeCable>();
  hal::Counters counters;
  PacketPort line(std::make_unique<tests::FakeStream>(cable), counters);
  PacketSender sender(line, 0us, counters);
  cable->bytes_a_write = 1 + input.byte();
  TimePoint now{};
  std::vector<Packet> meant;
  std::optional<Packet> wanted, last;
  for (int ms = 0; ms < 100'000 && (wanted || !input.empty()); ++ms, now += 1ms) {
    sender.poll(now);
    if (!sender.is_ready(now)) continue;
    if (!wanted) wanted = next_packet(input, last);
    const std::uint64_t before = counters["overhead.packets"];
    if (!sender.send(*wanted, 132ms, now)) continue;
    // a packet that is on the air already is not sent again
    if (counters["overhead.packets"] > before) meant.push_back(*wanted);
    last = std::exchange(wanted, std::nullopt);
  }
  for (int ms = 0; ms < 200; ++ms, now += 1ms) sender.poll(now);

  std::vector<Packet> heard;
  for (const auto& one : cable->heard) {
    if (!heard.empty()) require(heard.back() != one.packet);
    heard.push_back(one.packet);
  }
  require(heard.size() == counters["overhead.packets"]);
  std::erase_if(heard, [](const Packet& packet) { return packet[1] == static_cast<std::uint8_t>(PacketType::stop); });
  require(heard == meant);
  return 0;
}
