// TCP ports that a program of ours listens on itself.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <string>

#include "hal/event_loop.hpp"

namespace arkmesh::hal {

// Takes a port without listening yet: nobody can connect before listen() is called. Else as listen_on.
boost::asio::ip::tcp::acceptor take_port(EventLoop& loop, const std::string& address, std::uint16_t port,
                                         const std::string& what);

// Listens on `address`, an IP address of this machine or "localhost"; port 0 takes any free one. Programs that we start
// do not inherit it. Throws std::runtime_error with one sentence; `what` says in it what the port is for ("pictures").
boost::asio::ip::tcp::acceptor listen_on(EventLoop& loop, const std::string& address, std::uint16_t port,
                                         const std::string& what);

}  // namespace arkmesh::hal
