// A serial device through libserialport: 38400 baud, 8 data bits, no parity, 1 stop bit, no flow control, for us alone.
// Its path may also lead to a pseudo-terminal.
#pragma once

#include <memory>
#include <string>

#include "hal/platforms/kilobot/wire.hpp"

struct sp_port;

namespace arkmesh::hal::kilobot {

class DeviceWire final : public Wire {
 public:
  explicit DeviceWire(std::string path) : path_(std::move(path)) {}
  ~DeviceWire() override { close(); }
  DeviceWire(const DeviceWire&) = delete;
  DeviceWire& operator=(const DeviceWire&) = delete;
  void open() override;
  State check() override;
  std::size_t write(std::span<const std::uint8_t> bytes) override;
  std::size_t waiting_bytes() override;
  const std::string& trouble() const override { return terminal_ ? terminal_->trouble() : trouble_; }

 private:
  void close();
  void lose(std::string why);

  std::string path_;
  sp_port* port_ = nullptr;         // owned; null while closed
  std::unique_ptr<Wire> terminal_;  // in its place, where the path was last found to lead to a pseudo-terminal
  std::string trouble_;
};

}  // namespace arkmesh::hal::kilobot
