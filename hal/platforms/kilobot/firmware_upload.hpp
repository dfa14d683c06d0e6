// Puts a program on all robots at once: calls them to their boot loaders, then sends the program page by page, round
// after round. Nothing comes back from robots, so only a person who sees them knows when they have it: green flashes,
// then the new program.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "hal/platforms/kilobot/intel_hex.hpp"
#include "hal/platforms/kilobot/packet_sender.hpp"

namespace arkmesh::hal::kilobot {

class FirmwareUpload {
 public:
  struct Timing {
    std::chrono::microseconds boot_for{3'000'000};  // robots are called to their boot loaders for so long
    std::chrono::microseconds spacing{165'000};     // start to start of pages; below 132 ms the controller loses some
  };
  // `rounds` > 0 ends after so many; nothing: never.
  FirmwareUpload(Firmware firmware, std::optional<int> rounds, Timing timing)
      : firmware_(std::move(firmware)), rounds_(rounds), timing_(timing) {}

  // Sends what is due. A line that was lost and came back goes on with the page that it was lost at, without calling
  // the robots to their boot loaders again: that would make them forget the pages they have.
  void poll(PacketSender& sender, TimePoint now);

  bool is_calling() const { return !called_; }        // the call to boot loaders has not gone out
  int round() const { return round_; }                // rounds completed
  int page() const { return page_ < 0 ? 0 : page_; }  // pages of the present round sent
  int pages() const { return firmware_.pages(); }
  bool is_finished() const { return rounds_ && round_ >= *rounds_; }
  // How long one round takes.
  std::chrono::microseconds round_time() const { return (pages() + 1) * timing_.spacing; }

 private:
  Firmware firmware_;
  std::optional<int> rounds_;
  Timing timing_;
  bool called_ = false;
  int round_ = 0;
  int page_ = -1;  // next to send; -1: the number of pages
};

}  // namespace arkmesh::hal::kilobot
