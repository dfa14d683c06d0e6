#include "view/access.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <stdexcept>
#include <utility>

namespace arkmesh::view {
namespace {

// 128 random bits.
std::string make_secret() {
  std::array<unsigned char, 16> bytes;
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
    throw std::runtime_error("the system provides no random numbers for the page's token");
  std::string out;
  for (const unsigned char byte : bytes) out += fmt::format("{:02x}", byte);
  return out;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

bool equal_names(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

bool has_port(std::string_view host) {
  const auto colon = host.rfind(':');
  return colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos &&
         (host.front() == '[' || host.find(':') == colon);
}

std::string with_port(std::string_view host, std::uint16_t port) {
  return host.empty() || has_port(host) ? std::string(host) : fmt::format("{}:{}", host, port);
}

std::string in_brackets(std::string_view address) {
  return address.find(':') == std::string_view::npos ? std::string(address) : fmt::format("[{}]", address);
}

}  // namespace

Access::Access(std::vector<std::string> hosts, std::uint16_t port, bool secure)
    : hosts_(std::move(hosts)), port_(port), secure_(secure), token_(make_secret()), cookie_(make_secret()) {
  for (std::string& host : hosts_) host = with_port(host, port);
  hosts_.push_back(fmt::format("localhost:{}", port));
}

bool Access::is_host(std::string_view host, std::string_view reached) const {
  if (host.empty() || host.size() > 300) return false;
  // Browsers leave out the port that is a scheme's own.
  const std::string full = has_port(host) ? std::string(host) : with_port(host, secure_ ? 443 : 80);
  if (equal_names(full, fmt::format("{}:{}", in_brackets(reached), port_))) return true;
  return std::ranges::any_of(hosts_, [&](const std::string& known) { return equal_names(full, known); });
}

bool Access::is_own_origin(std::string_view origin, std::string_view host) const {
  return equal_names(origin, fmt::format("{}://{}", secure_ ? "https" : "http", host));
}

bool Access::is_token(std::string_view shown) const {
  return equal_in_constant_time(shown, token_);
}

std::string Access::set_cookie() const {
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}", cookie_name(), cookie_, secure_ ? "; Secure" : "");
}

bool Access::has_cookie(std::string_view header) const {
  const std::string name = cookie_name() + "=";
  bool found = false;
  while (!header.empty()) {
    const auto end = std::min(header.find(';'), header.size());
    std::string_view one = header.substr(0, end);
    header.remove_prefix(std::min(end + 1, header.size()));
    while (!one.empty() && one.front() == ' ') one.remove_prefix(1);
    if (one.starts_with(name)) found = equal_in_constant_time(one.substr(name.size()), cookie_) || found;
  }
  return found;
}

}  // namespace arkmesh::view
