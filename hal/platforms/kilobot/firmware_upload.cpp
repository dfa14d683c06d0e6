#include "hal/platforms/kilobot/firmware_upload.hpp"

#include <algorithm>

namespace arkmesh::hal::kilobot {
namespace {

// The controller begins a page at the end of the repetition that it is in, up to 10.4 ms late, and is deaf that much
// longer: so after the first page of a round, which interrupts the number of pages.
constexpr std::chrono::microseconds first_page_spacing{143'000};

}  // namespace

void FirmwareUpload::poll(PacketSender& sender, TimePoint now) {
  sender.poll(now);
  if (is_finished() || !sender.is_ready(now)) return;
  if (!called_) {
    called_ = sender.send(forward_packet(with_crc({.type = type_boot})), timing_.boot_for, now);
    return;
  }
  const Packet packet =
      page_ < 0 ? forward_packet(with_crc({.data = {static_cast<std::uint8_t>(pages())}, .type = type_boot_size}))
                : boot_page_packet(static_cast<std::uint8_t>(page_), firmware_.page(page_));
  if (!sender.send(packet, page_ == 0 ? std::max(timing_.spacing, first_page_spacing) : timing_.spacing, now)) return;
  if (++page_ < pages()) return;
  page_ = -1;
  ++round_;
}

}  // namespace arkmesh::hal::kilobot
