#include "view/view_config.hpp"

#include <boost/asio/ip/address.hpp>

namespace arkmesh::view {

void ViewConfig::fields(const hal::Section& view) {
  view.field(
      "use", use,
      {.help =
           "whether the lab has a page for browsers; of several labs in one process the first one's [view] counts"});
  view.field("port", port, {.range = {1, 65535}, .help = "TCP port of the page; when it is taken, the next free one"});
  view.field("address", address,
             {.help = "IP address that the page is served on; beyond loopback over TLS only, with the lab's key"});
  view.field("hosts", hosts,
             {.help = "names by which browsers may ask for the page, beside its address and localhost"});
  view.field("control", control, {.help = "whether those who have the page's token may command the lab"});
  view.field(
      "per_s", per_s,
      {.range = {0.1, 120}, .unit = "1/s", .help = "how often the page gets the newest message of a channel, at most"});
  view.field("viewers", viewers, {.range = {1, 1000}, .help = "browsers that may watch at a time"});
}

void ViewConfig::check(const hal::Section& view) const {
  boost::system::error_code wrong;
  boost::asio::ip::make_address(address, wrong);
  if (wrong && address != "localhost")
    view.refuse("address", "is no IP address; give one of this machine, such as 127.0.0.1, or 0.0.0.0 for all of them");
}

bool is_loopback(const std::string& address) {
  boost::system::error_code wrong;
  const auto ip = boost::asio::ip::make_address(address, wrong);
  return address == "localhost" || (!wrong && ip.is_loopback());
}

}  // namespace arkmesh::view
