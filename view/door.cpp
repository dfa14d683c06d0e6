#include "view/door.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <stdexcept>
#include <string>

#include "hal/listen.hpp"
#include "view/view_config.hpp"

namespace arkmesh::view {

namespace asio = boost::asio;

asio::ip::tcp::acceptor listen_from(hal::EventLoop& loop, const ServerOptions& options) {
  std::string why;
  for (int i = 0; i < std::max<int>(1, options.port == 0 ? 1 : options.ports) && options.port + i <= 65'535; ++i) try {
      return hal::listen_on(loop, options.address, static_cast<std::uint16_t>(options.port + i), "the page");
    } catch (const std::runtime_error& error) {
      if (why.empty()) why = error.what();
    }
  throw std::runtime_error(why);
}

std::unique_ptr<asio::ssl::context> make_tls(const ServerOptions& options) {
  if (is_loopback(options.address)) return nullptr;
  if (options.identity.empty())
    throw std::runtime_error(fmt::format(
        "the page is shown beyond this machine ({}) over TLS only, and there is no key for it", options.address));
  auto out = std::make_unique<asio::ssl::context>(asio::ssl::context::tlsv13_server);
  boost::system::error_code wrong;
  out->use_certificate_chain(asio::buffer(options.identity), wrong);
  if (!wrong) out->use_private_key(asio::buffer(options.identity), asio::ssl::context::pem, wrong);
  if (wrong) throw std::runtime_error(fmt::format("OpenSSL cannot use the key for the page: {}", wrong.message()));
  return out;
}

}  // namespace arkmesh::view
