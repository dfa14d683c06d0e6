// A TCP port that leads to an overhead controller elsewhere, for example ser2net's raw mode.
#pragma once

#include <sys/socket.h>

#include <array>
#include <string>
#include <vector>

#include "hal/platforms/kilobot/byte_stream.hpp"
#include "hal/wall_time.hpp"

namespace arkmesh::hal::kilobot {

class TcpStream final : public ByteStream {
 public:
  // `where` is host:port or [IPv6]:port. Throws PortError.
  explicit TcpStream(const std::string& where);
  ~TcpStream() override { close(); }
  TcpStream(const TcpStream&) = delete;
  TcpStream& operator=(const TcpStream&) = delete;
  void open() override;
  State check() override;
  std::size_t write(std::span<const std::uint8_t> bytes) override;
  std::size_t waiting_bytes() override;
  std::span<const std::uint8_t> heard() const override { return {heard_.data(), heard_bytes_}; }
  const std::string& trouble() const override { return trouble_; }

 private:
  struct Address {
    sockaddr_storage bytes;
    socklen_t length;
  };
  void close();
  void fail(const std::string& what, int code);

  std::string name_;                // tcp://host:port
  std::vector<Address> addresses_;  // tried in turn
  std::size_t next_ = 0;
  int fd_ = -1;
  bool connected_ = false;
  TimePoint began_{};  // to connect
  std::string trouble_;
  std::array<std::uint8_t, 4096> heard_{};
  std::size_t heard_bytes_ = 0;
};

}  // namespace arkmesh::hal::kilobot
