// No resolver on purpose: it would block, and the only name that may be used has one meaning.
#include "gateway/address.hpp"

#include <fmt/format.h>

#include <charconv>

#include "hal/config.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;

namespace {

constexpr std::string_view wrong_form =
    "must be HOST:PORT with a port from 0 to 65535, for example 127.0.0.1:7801 or [::1]:7801";
constexpr std::string_view wrong_machine =
    "is not on this machine; gateways of this version listen on and connect to 127.0.0.1, [::1] and localhost only, "
    "because "
    "nothing is encrypted yet";

// Empty when it went well.
std::string_view parse(std::string_view text, asio::ip::tcp::endpoint& endpoint) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return wrong_form;
  std::string_view host = text.substr(0, colon), digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc{} || end != digits.data() + digits.size()) return wrong_form;

  if (host == "localhost") host = "127.0.0.1";
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  boost::system::error_code no_address;
  const auto address = asio::ip::make_address(std::string(host), no_address);
  if (no_address) return host.empty() || bracketed ? wrong_form : wrong_machine;
  if (address.is_v6() != bracketed) return wrong_form;
  if (!address.is_loopback()) return wrong_machine;
  endpoint = {address, port};
  return {};
}

}  // namespace

std::string why_not_loopback(std::string_view text) {
  asio::ip::tcp::endpoint endpoint;
  return std::string(parse(text, endpoint));
}

asio::ip::tcp::endpoint loopback_endpoint(std::string_view text) {
  asio::ip::tcp::endpoint endpoint;
  if (const auto why = parse(text, endpoint); !why.empty())
    throw hal::ConfigError(fmt::format("address '{}' {}", text, why));
  return endpoint;
}

std::string to_text(const asio::ip::tcp::endpoint& endpoint) {
  const std::string host = endpoint.address().to_string();
  return endpoint.address().is_v6() ? fmt::format("[{}]:{}", host, endpoint.port())
                                    : fmt::format("{}:{}", host, endpoint.port());
}

}  // namespace arkmesh::gateway
