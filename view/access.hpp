// Who may see a page, and who may control what it shows. Any web page that somebody opens can ask this machine's ports
// for something, so each request must name the server as its user does (Host) and come from the server's own page
// (Origin). Pure, but for the chance that secrets are made of.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::view {

class Access {
 public:
  // `hosts`: names by which browsers may reach the server beside "localhost" and the addresses that they reached; with
  // a port or without one, which means the server's.
  Access(std::vector<std::string> hosts, std::uint16_t port, bool secure);

  // `reached`: the address of this machine that the connection came to, as text. `host`: the request's header; empty:
  // it has none.
  bool is_host(std::string_view host, std::string_view reached) const;
  // Whether a request to `host` comes from a page of this server's: of the same host, port and scheme.
  bool is_own_origin(std::string_view origin, std::string_view host) const;

  // What proves that somebody may control: printed for people, in the URL.
  const std::string& token() const { return token_; }
  bool is_token(std::string_view shown) const;
  // What a browser keeps once it has shown the token. Another secret, because browsers show cookies to every port of a
  // host.
  std::string set_cookie() const;
  // The value of a request's Cookie header.
  bool has_cookie(std::string_view header) const;

 private:
  std::string cookie_name() const { return "arkmesh_view_" + std::to_string(port_); }

  std::vector<std::string> hosts_;
  std::uint16_t port_;
  bool secure_;
  std::string token_, cookie_;
};

}  // namespace arkmesh::view
