// No resolver on purpose: it would block. The only name that has a meaning here is localhost.
#include "gateway/address.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "hal/config/config.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;

namespace {

constexpr std::string_view wrong_form =
    "must be HOST:PORT with a port from 0 to 65535, for example 127.0.0.1:7801 or [::1]:7801";
constexpr std::string_view wrong_machine =
    "is not on this machine; without encryption gateways listen on and connect to 127.0.0.1, [::1] and localhost only, "
    "across machines use tls://";
constexpr std::string_view wrong_host =
    "must be HOST:PORT with a port from 1 to 65535, for example roark.example.org:7444 or [2001:db8::7]:7444";
constexpr std::string_view wrong_listener =
    "must be tls://ADDRESS:PORT with an address of this machine in numbers, for example tls://0.0.0.0:7444";

// The brackets, in which a number with colons must stand, are taken off. False when the text has another form.
bool split(std::string_view text, Host& host, bool& bracketed) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return false;
  std::string_view name = text.substr(0, colon), digits = text.substr(colon + 1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), host.port);
  if (error != std::errc{} || end != digits.data() + digits.size()) return false;
  bracketed = name.size() > 2 && name.front() == '[' && name.back() == ']';
  if (bracketed) name = name.substr(1, name.size() - 2);
  host.name = name;
  return !name.empty();
}

// Empty when it went well.
std::string_view parse(std::string_view text, asio::ip::tcp::endpoint& endpoint, std::string_view when_not_a_number) {
  Host host;
  bool bracketed = false;
  if (!split(text, host, bracketed)) return wrong_form;
  if (host.name == "localhost") host.name = "127.0.0.1";
  boost::system::error_code no_address;
  const auto address = asio::ip::make_address(host.name, no_address);
  if (no_address) return bracketed ? wrong_form : when_not_a_number;
  if (address.is_v6() != bracketed) return wrong_form;
  endpoint = {address, host.port};
  return {};
}

std::string_view parse_loopback(std::string_view text, asio::ip::tcp::endpoint& endpoint) {
  if (const auto why = parse(text, endpoint, wrong_machine); !why.empty()) return why;
  return endpoint.address().is_loopback() ? std::string_view() : wrong_machine;
}

std::string_view parse_host(std::string_view text, Host& host) {
  bool bracketed = false;
  if (!split(text, host, bracketed) || host.port == 0 || host.name.size() > 253) return wrong_host;
  boost::system::error_code no_address;
  const auto address = asio::ip::make_address(host.name, no_address);
  if (!no_address) return address.is_v6() == bracketed ? std::string_view() : wrong_host;
  const bool is_name = !bracketed && std::ranges::all_of(host.name, [](unsigned char c) {
    return std::isalnum(c) || c == '.' || c == '-' || c == '_';
  });
  return is_name ? std::string_view() : wrong_host;
}

std::string_view parse_listening(std::string_view text, ListenAddress& listening) {
  listening.tls = is_tls(text);
  if (!listening.tls) return parse_loopback(text, listening.at);
  return parse(text.substr(tls_scheme.size()), listening.at, wrong_listener).empty() ? std::string_view()
                                                                                     : wrong_listener;
}

// What `parse` makes of the text, or a sentence that it makes nothing.
template <class Result>
Result parsed(std::string_view text, std::string_view (*parse_text)(std::string_view, Result&)) {
  Result result;
  if (const auto why = parse_text(text, result); !why.empty())
    throw hal::ConfigError(fmt::format("address '{}' {}", text, why));
  return result;
}

}  // namespace

std::string why_not_loopback(std::string_view text) {
  asio::ip::tcp::endpoint endpoint;
  return std::string(parse_loopback(text, endpoint));
}

asio::ip::tcp::endpoint loopback_endpoint(std::string_view text) {
  return parsed(text, parse_loopback);
}

std::string why_no_host(std::string_view text) {
  Host host;
  return std::string(parse_host(text, host));
}

Host read_host(std::string_view text) {
  return parsed(text, parse_host);
}

std::string why_not_listenable(std::string_view text) {
  ListenAddress listening;
  return std::string(parse_listening(text, listening));
}

ListenAddress read_listen_address(std::string_view text) {
  return parsed(text, parse_listening);
}

std::string to_text(const Host& host) {
  const bool has_colons = host.name.find(':') != std::string::npos;
  return has_colons ? fmt::format("[{}]:{}", host.name, host.port) : fmt::format("{}:{}", host.name, host.port);
}

std::string to_text(const asio::ip::tcp::endpoint& endpoint) {
  return to_text(Host{endpoint.address().to_string(), endpoint.port()});
}

}  // namespace arkmesh::gateway
