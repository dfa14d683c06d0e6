// A page beyond its own machine: over TLS, with a key of its own.
#include <doctest/doctest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <string>
#include <vector>

#include "gateway/links/browser_certificate.hpp"
#include "tests/support/view/browser.hpp"
#include "view/server.hpp"

namespace arkmesh::tests {
namespace {

namespace asio = boost::asio;
using Error = boost::system::error_code;

struct NoDesk final : view::Desk {
  nlohmann::json about() override { return {{"labs", {"shark"}}}; }
  void command(const nlohmann::json&, view::Answer&) override {}
  void request(const nlohmann::json&, view::Answer&) override {}
};

// The status line that such a client gets; the error's text when it gets none.
std::string ask(asio::io_context& loop, std::uint16_t port, const std::string& trusted, const std::string& name,
                const std::string& headers) {
  asio::ssl::context context(asio::ssl::context::tls_client);
  context.add_certificate_authority(asio::buffer(trusted));
  context.set_verify_mode(asio::ssl::verify_peer);
  context.set_verify_callback(asio::ssl::host_name_verification(name));
  asio::ssl::stream<asio::ip::tcp::socket> stream(loop, context);
  stream.next_layer().connect({asio::ip::make_address("127.0.0.1"), port});
  const std::string request = "GET /about.json HTTP/1.1\r\n" + headers + "\r\n";
  asio::streambuf answer;
  std::string out;
  bool done = false;
  stream.async_handshake(asio::ssl::stream_base::client, [&](Error error) {
    if (error) return out = error.message(), void(done = true);
    asio::async_write(stream, asio::buffer(request), [&](Error, std::size_t) {
      asio::async_read_until(stream, answer, "\r\n", [&](Error, std::size_t size) {
        out.assign(asio::buffers_begin(answer.data()),
                   asio::buffers_begin(answer.data()) + static_cast<std::ptrdiff_t>(size));
        done = true;
      });
    });
  });
  comes_to(serving(loop), [&] { return done; });
  return out;
}

TEST_CASE("a page's key is kept, and its certificate as long as it is for the same names") {
  const std::vector<std::string> hosts{"192.0.2.7", "lab.example"};
  const auto first = gateway::browser_certificate("shark", hosts);
  const auto key_of = [](const std::string& pem) {
    const auto at = pem.find("-----BEGIN PRIVATE KEY");
    return pem.substr(at, pem.find("-----BEGIN CERTIFICATE") - at);
  };
  CHECK(first.pem.find("-----BEGIN CERTIFICATE-----") != std::string::npos);
  CHECK(first.fingerprint.size() == 95);
  const auto kept = gateway::browser_certificate("shark", hosts, first.pem);
  CHECK(kept.pem == first.pem);
  CHECK(kept.fingerprint == first.fingerprint);
  const auto elsewhere = gateway::browser_certificate("shark", {"192.0.2.8"}, first.pem);
  CHECK(elsewhere.fingerprint != first.fingerprint);
  CHECK(key_of(elsewhere.pem) == key_of(first.pem));
  CHECK(gateway::browser_certificate("roark", hosts, first.pem).fingerprint != first.fingerprint);
  const auto other = gateway::browser_certificate("shark", hosts, "junk");
  CHECK(key_of(other.pem) != key_of(first.pem));
  // A certificate of another key is not kept.
  const std::string mixed = first.pem.substr(0, first.pem.find('\n') + 1) + key_of(other.pem) +
                            first.pem.substr(first.pem.find("-----BEGIN CERTIFICATE"));
  CHECK(gateway::browser_certificate("shark", hosts, mixed).fingerprint != first.fingerprint);
  CHECK_NOTHROW(gateway::browser_certificate("shark", {"a,DNS:evil", "", "x y"}));
}

TEST_CASE("beyond loopback a page is served over TLS only, and Host and Origin count there, too") {
  const auto shown = gateway::browser_certificate("shark", {"127.0.0.1", "lab.example"});
  asio::io_context loop;
  NoDesk desk;
  view::Server server(loop, {.address = "0.0.0.0", .port = 0, .hosts = {"lab.example"}, .identity = shown.pem}, desk);
  const std::string port = std::to_string(server.port());
  CHECK(server.url() == "https://lab.example:" + port + "/");
  const auto status = [&](const std::string& headers) {
    return ask(loop, server.port(), shown.pem, "127.0.0.1", headers);
  };
  CHECK(status("Host: 127.0.0.1:" + port + "\r\n") == "HTTP/1.1 200 OK\r\n");
  CHECK(status("Host: lab.example:" + port + "\r\nOrigin: https://lab.example:" + port + "\r\n") ==
        "HTTP/1.1 200 OK\r\n");
  CHECK(status("Host: evil.example:" + port + "\r\n").starts_with("HTTP/1.1 403"));
  CHECK(status("Host: lab.example:" + port + "\r\nOrigin: http://lab.example:" + port + "\r\n")
            .starts_with("HTTP/1.1 403"));
  // Another key's certificate is not this one's.
  CHECK(ask(loop, server.port(), gateway::browser_certificate("shark", {"127.0.0.1"}).pem, "127.0.0.1", "")
            .find("certificate verify failed") != std::string::npos);
  // Who speaks no TLS gets nothing.
  Browser plain(loop, server.port());
  CHECK(plain.ask("GET /about.json").empty());
  CHECK(comes_to(serving(loop), [&] { return server.counters()["view.sent_away.no_handshake"] >= 2; }));
}

}  // namespace
}  // namespace arkmesh::tests
