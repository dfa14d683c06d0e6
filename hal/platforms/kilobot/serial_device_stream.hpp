// A serial device through libserialport: 38400 baud, 8 data bits, no parity, 1 stop bit, no flow control, for us alone.
// Its path may also lead to a pseudo-terminal.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "hal/platforms/kilobot/byte_stream.hpp"

struct sp_port;

namespace arkmesh::hal::kilobot {

class SerialDeviceStream final : public ByteStream {
 public:
  explicit SerialDeviceStream(std::string path) : path_(std::move(path)) {}
  ~SerialDeviceStream() override { close(); }
  SerialDeviceStream(const SerialDeviceStream&) = delete;
  SerialDeviceStream& operator=(const SerialDeviceStream&) = delete;
  void open() override;
  State check() override;
  std::size_t write(std::span<const std::uint8_t> bytes) override;
  std::size_t waiting_bytes() override;
  std::span<const std::uint8_t> heard() const override {
    return terminal_ ? terminal_->heard() : std::span(heard_.data(), heard_bytes_);
  }
  const std::string& trouble() const override { return terminal_ ? terminal_->trouble() : trouble_; }

 private:
  void close();
  void lose(std::string why);

  std::string path_;
  sp_port* port_ = nullptr;               // owned; null while closed
  std::unique_ptr<ByteStream> terminal_;  // in its place, where the path was last found to lead to a pseudo-terminal
  std::string trouble_;
  std::array<std::uint8_t, 4096> heard_{};
  std::size_t heard_bytes_ = 0;
};

}  // namespace arkmesh::hal::kilobot
