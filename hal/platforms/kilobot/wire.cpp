#include "hal/platforms/kilobot/wire.hpp"

#include <fmt/format.h>

#include "hal/platforms/kilobot/device_wire.hpp"
#include "hal/platforms/kilobot/tcp_wire.hpp"

namespace arkmesh::hal::kilobot {

std::unique_ptr<Wire> make_wire(const std::string& port) {
  constexpr std::string_view tcp = "tcp://";
  if (port.starts_with(tcp)) return std::make_unique<TcpWire>(port.substr(tcp.size()));
  if (port.empty())
    throw PortError(
        "the name of the overhead controller's port is empty; write a device such as /dev/ttyUSB0, or tcp://host:port");
  if (port.find("://") != std::string::npos)
    throw PortError(fmt::format("{}: write a device such as /dev/ttyUSB0, or tcp://host:port", port));
  return std::make_unique<DeviceWire>(port.front() == '/' ? port : "/dev/" + port);
}

}  // namespace arkmesh::hal::kilobot
