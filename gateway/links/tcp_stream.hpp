// A session's connection over TCP, on this machine.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <optional>

#include "gateway/links/socket_stream.hpp"

namespace arkmesh::gateway {

// Over a socket that was accepted, or that connects to `to` when it is opened.
std::unique_ptr<SocketStream> tcp_stream(boost::asio::ip::tcp::socket socket,
                                         std::optional<boost::asio::ip::tcp::endpoint> to = {});

// Small messages go at once, and little waits in the kernel that newer messages could still replace.
void prepare(boost::asio::ip::tcp::socket& socket);

// Of an attempt to connect that failed.
StreamFailure no_connection(const std::string& there, const boost::system::error_code& error);

}  // namespace arkmesh::gateway
