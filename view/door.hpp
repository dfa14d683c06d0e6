// Where browsers come in: the port, and TLS beyond this machine.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <memory>

#include "hal/event_loop.hpp"
#include "view/server.hpp"

namespace arkmesh::view {

// On the first free port of those that the options allow. Throws std::runtime_error in one sentence when there is none.
boost::asio::ip::tcp::acceptor listen_from(hal::EventLoop& loop, const ServerOptions& options);
// Null on loopback. Throws std::runtime_error in one sentence when beyond it there is no identity, or none that is
// good.
std::unique_ptr<boost::asio::ssl::context> make_tls(const ServerOptions& options);

}  // namespace arkmesh::view
