#include "view/view_config.hpp"

#include <boost/asio/ip/address.hpp>
#include <charconv>

namespace arkmesh::view {

void ViewConfig::fields(const hal::Section& view) {
  view.field(
      "use", use,
      {.help =
           "whether the lab has a page for browsers; of several labs in one process the first one's [view] counts"});
  view.field("port", port, {.range = {1, 65535}, .help = "TCP port of the page; when it is taken, the next free one"});
  view.field("address", address,
             {.help = "IP address that the page is served on; beyond loopback over TLS only, with a key of its own"});
  view.field("hosts", hosts,
             {.help = "names by which browsers may ask for the page, beside its address and localhost"});
  view.field("control", control, {.help = "whether those who have the page's token may command the lab"});
  view.field(
      "per_s", per_s,
      {.range = {0.1, 120}, .unit = "1/s", .help = "how often the page gets the newest message of a channel, at most"});
  view.field("viewers", viewers, {.range = {1, 1000}, .help = "browsers that may watch at a time"});
  view.field("emulator", emulator,
             {.help = "control port of an emulated testbed that is a process of its own, as \"127.0.0.1:8092\": takes "
                      "the page's faults and moves of this lab's robots"});
}

void ViewConfig::check(const hal::Section& view) const {
  boost::system::error_code wrong;
  boost::asio::ip::make_address(address, wrong);
  if (wrong && address != "localhost")
    view.refuse("address", "is no IP address; give one of this machine, such as 127.0.0.1, or 0.0.0.0 for all of them");
  if (!emulator.empty() && !endpoint_of(emulator))
    view.refuse("emulator", "is no IP address with a port; give that of the emulator's commands, as 127.0.0.1:8092");
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
