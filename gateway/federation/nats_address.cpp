#include "gateway/federation/nats_address.hpp"

#include <fmt/format.h>

#include "hal/config/config.hpp"
#include "hal/config/without_secrets.hpp"

namespace arkmesh::gateway {
namespace {

constexpr std::string_view default_port = ":4222";
constexpr std::string_view wrong_form =
    "must be [USER:PASSWORD@]HOST[:PORT], or several separated by commas, for example "
    "nats.example.org:4222,nats2.example.org";

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// Empty when it went well.
std::string parse_server(std::string_view text, NatsServer& server) {
  for (const std::string_view scheme : {"tls+nats://", "nats://"})
    if (text.starts_with(scheme)) text.remove_prefix(scheme.size());
  if (const std::size_t at = text.rfind('@'); at != std::string_view::npos) {
    const std::string_view who = text.substr(0, at);
    const std::size_t colon = who.find(':');
    if (colon == std::string_view::npos || colon == 0 || colon + 1 == who.size()) return std::string(wrong_form);
    server.user = who.substr(0, colon);
    server.password = who.substr(colon + 1);
    text.remove_prefix(at + 1);
  }
  std::string address(text);
  const std::size_t bracket = text.rfind(']');
  if (text.find(':', bracket == std::string_view::npos ? 0 : bracket) == std::string_view::npos)
    address += default_port;
  if (!why_no_host(address).empty()) return std::string(wrong_form);
  server.host = read_host(address);
  return {};
}

std::string parse(std::string_view text, NatsServers& servers) {
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    more = comma != std::string_view::npos;
    if (const std::string why = parse_server(trimmed(text.substr(0, comma)), servers.all.emplace_back()); !why.empty())
      return why;
    if (more) text.remove_prefix(comma + 1);
  }
  return {};
}

}  // namespace

std::string why_no_servers(std::string_view text) {
  NatsServers servers;
  return parse(text, servers);
}

std::string why_no_open_servers(std::string_view text) {
  NatsServers servers;
  if (const std::string why = parse(text, servers); !why.empty()) return why;
  for (const NatsServer& each : servers.all)
    if (!each.password.empty() && !why_not_loopback(to_text(each.host)).empty())
      return fmt::format("would send a password to {} unencrypted; use tls+nats://", to_text(each.host));
  return {};
}

NatsServers read_servers(std::string_view text, bool tls) {
  NatsServers servers{.tls = tls};
  if (const std::string why = parse(text, servers); !why.empty())
    throw hal::ConfigError(fmt::format("address '{}' {}", hal::without_secrets(text), why));
  return servers;
}

}  // namespace arkmesh::gateway
