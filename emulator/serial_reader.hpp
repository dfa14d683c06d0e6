// Reads what hosts write to the emulator's overhead controller, and notes when it came. A thread of its own: the
// emulator's pictures take tens of milliseconds, but on a serial line milliseconds count (packets 55 ms apart would
// otherwise come in one piece).
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "emulator/byte_ports.hpp"

namespace arkmesh::emulator {

class SerialReader {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  struct Chunk {
    TimePoint at;
    std::vector<std::uint8_t> bytes;
  };

  // Opens a pseudo-terminal (with a link to it unless `link` is empty) and a TCP port. Throws std::runtime_error with
  // one sentence.
  SerialReader(const std::string& address, std::uint16_t port, const std::string& link);
  ~SerialReader();
  SerialReader(const SerialReader&) = delete;
  SerialReader& operator=(const SerialReader&) = delete;

  // What has come since the last call; nothing that comes later bears an earlier time than `until`.
  std::deque<Chunk> take(TimePoint& until);
  // Unplugged, the pseudo-terminal is gone and TCP clients are sent away; plugged in again there is a new
  // pseudo-terminal.
  void set_plugged(bool plugged);
  // Empty while unplugged.
  std::string terminal() const;
  std::uint16_t port() const { return tcp_port_; }

 private:
  void run();

  std::string link_;
  std::uint16_t tcp_port_ = 0;
  mutable std::mutex mutex_;  // guards everything below
  std::unique_ptr<PseudoTerminal> terminal_;
  TcpPort tcp_;
  std::deque<Chunk> chunks_;
  std::size_t held_bytes_ = 0;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace arkmesh::emulator
