#include "hal/platforms/kilobot/byte_stream.hpp"

#include <fmt/format.h>

#include "hal/platforms/kilobot/serial_device_stream.hpp"
#include "hal/platforms/kilobot/tcp_stream.hpp"

namespace arkmesh::hal::kilobot {

std::unique_ptr<ByteStream> make_byte_stream(const std::string& port) {
  constexpr std::string_view tcp = "tcp://";
  if (port.starts_with(tcp)) return std::make_unique<TcpStream>(port.substr(tcp.size()));
  if (port.empty())
    throw PortError(
        "the name of the overhead controller's port is empty; write a device such as /dev/ttyUSB0, or tcp://host:port");
  if (port.find("://") != std::string::npos)
    throw PortError(fmt::format("{}: write a device such as /dev/ttyUSB0, or tcp://host:port", port));
  return std::make_unique<SerialDeviceStream>(port.front() == '/' ? port : "/dev/" + port);
}

}  // namespace arkmesh::hal::kilobot
