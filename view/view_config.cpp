#include "view/view_config.hpp"

#include <boost/asio/ip/address.hpp>
#include <charconv>

namespace arkmesh::view {

void ViewConfig::fields(const hal::Section& view) {
  view.field("use", use, {.help = "serve a page for browsers; several labs in one process use the first lab's [view]"});
  view.field("port", port, {.range = {1, 65535}, .help = "TCP port of the page; if it is taken, the next free one"});
  view.field("address", address, {.help = "IP address of the page; beyond loopback it uses TLS, with its own key"});
  view.field("hosts", hosts, {.help = "further host names of the page, besides its address and localhost"});
  view.field("control", control, {.help = "let holders of the page's token command the lab"});
  view.field(
      "per_s", per_s,
      {.range = {0.1, 120}, .unit = "1/s", .help = "limit of messages to the page, per channel; it gets the newest"});
  view.field("viewers", viewers, {.range = {1, 1000}, .help = "how many browsers may watch at once"});
  view.field("emulator", emulator,
             {.help = "control port of a separate emulator process, as \"127.0.0.1:8092\"; it receives the page's "
                      "faults and moves of robots"});
}

void ViewConfig::check(const hal::Section& view) const {
  boost::system::error_code wrong;
  boost::asio::ip::make_address(address, wrong);
  if (wrong && address != "localhost")
    view.refuse("address",
                "is not an IP address; give one of this machine, such as 127.0.0.1, or 0.0.0.0 for all of them");
  if (!emulator.empty() && !endpoint_of(emulator))
    view.refuse("emulator",
                "is not an IP address with a port; give that of the emulator's commands, as 127.0.0.1:8092");
}

std::optional<boost::asio::ip::tcp::endpoint> endpoint_of(const std::string& text) {
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return {};
  std::string host = text.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  std::uint16_t port = 0;
  const auto [end, bad] = std::from_chars(text.data() + colon + 1, text.data() + text.size(), port);
  boost::system::error_code wrong;
  const auto ip = boost::asio::ip::make_address(host, wrong);
  if (wrong || bad != std::errc() || end != text.data() + text.size() || port == 0) return {};
  return boost::asio::ip::tcp::endpoint(ip, port);
}

bool is_loopback(const std::string& address) {
  boost::system::error_code wrong;
  const auto ip = boost::asio::ip::make_address(address, wrong);
  return address == "localhost" || (!wrong && ip.is_loopback());
}

}  // namespace arkmesh::view
