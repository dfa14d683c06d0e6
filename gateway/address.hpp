// Where gateways listen and connect. Only this machine: there is no encryption yet.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <string_view>

namespace arkmesh::gateway {

// "127.0.0.1:7801", "[::1]:7801", "localhost:7801". Port 0 is allowed: when listening, the system chooses one.
// Empty when the text is such an address, else what is wrong with it, as the end of a sentence.
std::string why_not_loopback(std::string_view text);
// Throws hal::ConfigError with one sentence when it is none.
boost::asio::ip::tcp::endpoint loopback_endpoint(std::string_view text);
// The same back again.
std::string to_text(const boost::asio::ip::tcp::endpoint& endpoint);

}  // namespace arkmesh::gateway
