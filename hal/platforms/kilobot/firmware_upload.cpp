#include "hal/platforms/kilobot/firmware_upload.hpp"

namespace arkmesh::hal::kilobot {
namespace {

Message with_crc(Message message) {
  message.crc = message_crc(message);
  return message;
}

}  // namespace

void FirmwareUpload::tend(PacketSender& sender, Moment now) {
  sender.tend(now);
  if (is_finished() || !sender.is_ready(now)) return;
  if (!called_) {
    called_ = sender.send(forward_packet(with_crc({.type = type_boot})), timing_.boot_for, now);
    return;
  }
  const Packet packet = page_ < 0 ? forward_packet(with_crc({.data = {static_cast<std::uint8_t>(pages())}, .type = type_boot_size}))
                                  : boot_page_packet(static_cast<std::uint8_t>(page_), firmware_.page(page_));
  if (!sender.send(packet, timing_.spacing, now)) return;
  if (++page_ < pages()) return;
  page_ = -1;
  ++round_;
}

}  // namespace arkmesh::hal::kilobot
