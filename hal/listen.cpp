#include "hal/listen.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <boost/asio/io_context.hpp>
#include <stdexcept>

namespace arkmesh::hal {

namespace asio = boost::asio;
using boost::asio::ip::tcp;

namespace {

// Throws what is wrong with a port, in one sentence; nothing when nothing is.
void check(const boost::system::error_code& wrong, const std::string& address, std::uint16_t port,
           const std::string& what) {
  if (wrong == asio::error::address_in_use)
    throw std::runtime_error(fmt::format(
        "TCP port {} of {}, for {}, is in use by another program; stop it (ss -ltnp shows it) or give another port",
        port, address, what));
  if (wrong == asio::error::access_denied)
    throw std::runtime_error(
        fmt::format("TCP port {}, for {}, is not allowed to ordinary users; use one above 1023", port, what));
  if (wrong)
    throw std::runtime_error(
        fmt::format("cannot listen on {} port {} for {}: {}", address, port, what, wrong.message()));
}

}  // namespace

tcp::acceptor take_port(EventLoop& loop, const std::string& address, std::uint16_t port, const std::string& what) {
  boost::system::error_code wrong;
  const auto ip = asio::ip::make_address(address == "localhost" ? "127.0.0.1" : address, wrong);
  if (wrong)
    throw std::runtime_error(
        fmt::format("'{}' is not an address to listen on for {}; give an IP address of this machine, such as 127.0.0.1",
                    address, what));
  const tcp::endpoint here(ip, port);
  tcp::acceptor out(loop);
  out.open(here.protocol(), wrong);
  if (!wrong) out.set_option(tcp::acceptor::reuse_address(true), wrong);
  if (!wrong) out.bind(here, wrong);
  check(wrong, address, port, what);
  ::fcntl(out.native_handle(), F_SETFD, FD_CLOEXEC);
  return out;
}

tcp::acceptor listen_on(EventLoop& loop, const std::string& address, std::uint16_t port, const std::string& what) {
  tcp::acceptor out = take_port(loop, address, port, what);
  boost::system::error_code wrong;
  out.listen(16, wrong);
  check(wrong, address, port, what);
  return out;
}

}  // namespace arkmesh::hal
