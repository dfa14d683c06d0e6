// Bytes through a file descriptor: a serial device, a pseudo-terminal in its place, or a TCP connection.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>

#include "hal/handle.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/platforms/kilobot/packet.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal::kilobot {

// What differs between kinds of ports: how one is opened, and what its end is called.
struct Line {
  // A descriptor that never blocks. Throws PortError: why there is none, one sentence.
  std::function<Handle()> open;
  // One sentence for a line that was open or could not be, by its errno, or 0.
  std::function<std::string(bool was_open, int code)> why_lost;
  bool connects = false;  // open() only begins to connect
  // Both are kept for as long as the stream lives; null: none.
  std::shared_ptr<PortLock> lock;
  std::shared_ptr<StandGuard> guard = nullptr;  // has each line that is open, too, and may take it
};

// `path` leads to a serial device or a pseudo-terminal, and is looked up anew by each open(): 8 data bits, no parity, 1
// stop bit, no flow control, for us alone.
Line serial_line(const std::string& path, int baud = line_baud);
// `where` is host:port or [IPv6]:port. Resolves a host's name once, which may take as long as the system's resolver
// does; its addresses are tried in turn. Throws PortError. `hint`: for who finds nobody there.
Line tcp_line(const std::string& where, const std::string& hint = "is ser2net running, and is this its port?");
// `port` is a device, such as /dev/ttyUSB0, or tcp://host:port. As slow as tcp_line(). Throws PortError.
Line find_line(const std::string& port);

class DescriptorStream final : public ByteStream {
 public:
  explicit DescriptorStream(Line line) : line_(std::move(line)) {}
  ~DescriptorStream() override { close(); }
  void open() override;
  State check() override;
  std::span<const std::uint8_t> heard() const override { return {heard_.data(), heard_bytes_}; }
  std::size_t write(std::span<const std::uint8_t> bytes) override;
  std::size_t waiting_bytes() override;
  bool reset() override;
  const std::string& error() const override { return error_; }

 private:
  State lose(int code);
  void opened();
  void close();

  Line line_;
  Handle descriptor_;  // none while closed
  bool open_ = false;  // and connected
  TimePoint began_{};  // to connect
  std::string error_;
  std::array<std::uint8_t, 4096> heard_{};
  std::size_t heard_bytes_ = 0;
};

}  // namespace arkmesh::hal::kilobot
