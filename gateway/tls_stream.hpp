// A session's connection over TLS 1.3: both ends show a certificate, and the other end's name is what its pinned
// certificate says.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <memory>
#include <string>

#include "gateway/address.hpp"
#include "gateway/byte_stream.hpp"
#include "gateway/tls_keys.hpp"

namespace arkmesh::gateway {

// Over a socket that was accepted.
std::unique_ptr<ByteStream> tls_stream(boost::asio::ip::tcp::socket socket, std::shared_ptr<TlsKeys> keys);
// Connects to `to` when it is opened, and only to lab `expected`. Of several addresses of a name, attempt number
// `attempt` begins with another one than the attempt before.
std::unique_ptr<ByteStream> tls_stream(boost::asio::ip::tcp::socket socket, std::shared_ptr<TlsKeys> keys, Host to,
                                       std::string expected, std::size_t attempt);

}  // namespace arkmesh::gateway
