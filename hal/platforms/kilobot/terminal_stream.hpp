// A pseudo-terminal (socat, arkmesh emulator) in place of a serial device: libserialport 0.1.1 opens none, because they
// have no modem lines.
#pragma once

#include <array>
#include <string>

#include "hal/handle.hpp"
#include "hal/platforms/kilobot/byte_stream.hpp"

namespace arkmesh::hal::kilobot {

// Why a device cannot be opened that another program has, one sentence.
std::string why_in_use(const std::string& path);

class TerminalStream final : public ByteStream {
 public:
  explicit TerminalStream(std::string path) : path_(std::move(path)) {}
  void open() override;
  State check() override;
  std::size_t write(std::span<const std::uint8_t> bytes) override;
  std::size_t waiting_bytes() override;
  const std::string& trouble() const override { return trouble_; }
  std::span<const std::uint8_t> heard() const override { return {heard_.data(), heard_bytes_}; }

 private:
  void lose(std::string why);

  std::string path_;
  Handle terminal_;  // none while closed
  std::string trouble_;
  std::array<std::uint8_t, 4096> heard_{};
  std::size_t heard_bytes_ = 0;
};

}  // namespace arkmesh::hal::kilobot
