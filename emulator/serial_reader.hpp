// Reads what hosts write to the emulator's overhead controller, over a pseudo-terminal, which looks like a serial port,
// and over TCP, as ser2net offers one, and notes when it came. On a loop and a thread of its own: the emulator's loop
// draws pictures for tens of milliseconds, but on a serial line milliseconds count (hal/README.md has the figures).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "emulator/pseudo_terminal.hpp"
#include "hal/event_loop.hpp"

namespace arkmesh::emulator {

class SerialReader {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  struct Chunk {
    TimePoint at;
    std::vector<std::uint8_t> bytes;  // none: the host has reset its connection, what is not on the line yet is lost
    bool refused = false;             // another host was sent away; without bytes
  };

  // Opens a pseudo-terminal (with a link to it unless `link` is empty) and a TCP port, which takes one host at a time,
  // as a serial port does. `take` is called on `loop`, which outlives the reader, for each chunk in the order of their
  // times. Throws std::runtime_error with one sentence.
  SerialReader(hal::EventLoop& loop, const std::string& address, std::uint16_t port, const std::string& link,
               std::function<void(Chunk)> take);
  ~SerialReader();
  SerialReader(const SerialReader&) = delete;
  SerialReader& operator=(const SerialReader&) = delete;

  // So many of the bytes taken are dealt with. What is not is bounded: the rest stays with the writer, as at a real
  // port.
  void done(std::size_t bytes);
  // Unplugged, the pseudo-terminal is gone and the TCP host is sent away; plugged in again there is a new
  // pseudo-terminal.
  void set_plugged(bool plugged);
  // Empty while unplugged.
  std::string terminal() const { return terminal_ ? terminal_->path() : std::string{}; }
  std::uint16_t port() const { return port_; }

 private:
  struct Thread;  // what only the thread touches

  std::string link_;
  std::optional<PseudoTerminal> terminal_;
  std::uint16_t port_ = 0;
  std::shared_ptr<std::function<void(Chunk)>> take_;  // what is under way on the loop holds it weakly
  std::unique_ptr<Thread> reading_;
  std::thread thread_;
};

}  // namespace arkmesh::emulator
