// A session's connection over TLS 1.3: both ends show a certificate, and the other end's name is what its pinned
// certificate says.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "gateway/address.hpp"
#include "gateway/links/socket_stream.hpp"
#include "gateway/links/tls_keys.hpp"

namespace arkmesh::gateway {

// Over a socket that was accepted.
std::unique_ptr<SocketStream> tls_stream(boost::asio::ip::tcp::socket socket, std::shared_ptr<TlsKeys> keys);
// What attempts to connect to one peer know of the ones before.
struct Attempts {
  std::size_t number = 0;                                 // of the newest, from 1 on; counted by the caller
  std::vector<boost::asio::ip::tcp::endpoint> addresses;  // the newest that the host's name had
};
// Connects to `to` when it is opened, and only to lab `expected`. Of several addresses of a name, each attempt begins
// with another one than the attempt before; every second one takes the known addresses, for a broken path may be that
// to the name server, too.
std::unique_ptr<SocketStream> tls_stream(boost::asio::ip::tcp::socket socket, std::shared_ptr<TlsKeys> keys, Host to,
                                         std::string expected, std::shared_ptr<Attempts> attempts);

}  // namespace arkmesh::gateway
