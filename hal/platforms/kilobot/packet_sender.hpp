// Lets packets follow each other on a line so that an overhead controller understands each, and so that what it says
// reaches the air: spacing, the controller's start-up, and stops between packets that could be misread together. Does
// not know what is said.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "hal/counters.hpp"
#include "hal/platforms/kilobot/packet.hpp"
#include "hal/platforms/kilobot/packet_port.hpp"

namespace arkmesh::hal::kilobot {

class PacketSender {
 public:
  // `settle`: a controller that begins to live when its port opens (Arduino boards) hears nothing for so long. `line`
  // and `counters` outlive this. Counts `overhead.packets` and, of these, `overhead.parting_stops`.
  PacketSender(PacketPort& line, std::chrono::microseconds settle, Counters& counters)
      : port_(line), settle_(settle), counters_(counters) {}

  // Tends the line. After each opening the controller is told to stop, whatever it did before.
  void poll(TimePoint now);
  // The line is open and the controller listens.
  bool is_up() const { return up_; }
  // The next packet may begin.
  bool is_ready(TimePoint now) const;
  // When is_ready() can become true, or poll() should look at the line again: within 20 ms.
  TimePoint due(TimePoint now) const;

  // Call it only when ready. True: the packet goes out, or is on the air already and stays there; nothing else begins
  // for `hold`, counted from its first byte. False: a stop had to go first, offer the packet again when ready.
  [[nodiscard]] bool send(const Packet& packet, std::chrono::microseconds hold, TimePoint now);
  // A stop, behind which the packet on the air can be sent once more: nobody says whether the line has spoilt it. Call
  // it only when ready.
  void separate(TimePoint now);
  // The controller repeats something: only a stop makes the air free.
  bool is_repeating() const;
  // The next packet need not wait for the hold of the last one to end.
  void cut_short(TimePoint now);
  // Gives a connection up with what waits in it. From then until expect_start() the controller is told at once after an
  // opening, though it may be deaf: it did not begin anew where the line goes on. False: the line is no connection.
  bool reset() { return at_once_ = port_.reset(); }
  void expect_start() { at_once_ = false; }
  // Grows each time that the controller may have forgotten what it was told.
  std::uint64_t openings() const { return openings_; }

 private:
  TimePoint may_begin() const;
  void put(const Packet& packet, std::chrono::microseconds hold, TimePoint now);

  PacketPort& port_;
  std::chrono::microseconds settle_;
  Counters& counters_;
  std::uint64_t openings_ = 0;
  bool up_ = false, at_once_ = false;
  TimePoint settled_at_{};
  std::optional<Packet> last_;         // since the line opened
  TimePoint begun_{};                  // of last_
  std::chrono::microseconds hold_{0};  // of last_
};

}  // namespace arkmesh::hal::kilobot
