// A Kilobot's boot loader: which pages of a new program have come, and what its LED shows meanwhile. Keeps no program:
// simulated robots go on with theirs.
#pragma once

#include <bitset>
#include <cstdint>

#include "sim_ode/host/turns/reception.hpp"

namespace arkmesh::sim_ode {

class BootLoader {
 public:
  // Waits for a program; what came of an earlier one is forgotten.
  void start() {
    written_.reset();
    announced_ = announced_first;
    bytes_ = ticks_ = 0;
    page_ = -1;
    colour_ = 0;
  }
  // True: the robot leaves the boot loader, through its reset.
  bool hear(const Message& message) {
    switch (message.type) {
      case type_boot:
        start();
        return false;
      case type_boot_size:
        announced_ = message.data[0];
        return complete();
      case type_boot_page:
        return add(message.data[0]);
      default:
        return written_.none();  // any other message, as long as there is no half program
    }
  }
  // Kilolib colour.
  std::uint8_t colour() const { return colour_; }
  // A tick has passed. While it waits it flashes blue every second, too briefly for a camera; true: it is dark after
  // one.
  bool flashes() {
    if (++ticks_ < flash_ticks) return false;
    ticks_ = 0;
    colour_ = 0;
    return true;
  }
  // Since power-up, over all uploads.
  std::uint64_t pages_written() const { return total_; }

 private:
  static constexpr unsigned page_bytes = 128, bytes_per_message = 6, flash_ticks = 31;
  static constexpr unsigned announced_first = 220;  // until it is told another number of pages
  static constexpr std::uint8_t dim_blue = 0x10, bright_green = 0x0C;

  // Exactly as many as announced: it waits for ever when a smaller program is announced than it has written.
  bool complete() const { return written_.count() == announced_; }
  // A page must come whole in one visit, in whatever order its messages are.
  bool add(std::uint8_t page) {
    if (page != page_) {
      page_ = page;
      bytes_ = 0;
    }
    colour_ = dim_blue;
    if (written_[page]) return false;
    bytes_ += bytes_per_message;
    if (bytes_ < page_bytes) return false;
    written_[page] = true;
    ++total_;
    colour_ = bright_green;
    return complete();
  }

  std::bitset<256> written_;
  unsigned announced_ = announced_first, bytes_ = 0, ticks_ = 0;
  int page_ = -1;
  std::uint8_t colour_ = 0;
  std::uint64_t total_ = 0;
};

}  // namespace arkmesh::sim_ode
