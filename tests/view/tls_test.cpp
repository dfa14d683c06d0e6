// A page beyond its own machine: over TLS, with what is made of the lab's key.
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

#include "gateway/browser_certificate.hpp"
#include "gateway/certificate.hpp"
#include "hal/config.hpp"
#include "tests/support/view/browser.hpp"
#include "view/server.hpp"

namespace arkmesh::tests {
namespace {

namespace asio = boost::asio;
using Error = boost::system::error_code;

struct LabKey {
  std::string key = gateway::make_key(), certificate = gateway::make_certificate(key, "shark");
  gateway::BrowserCertificate for_browsers(const std::vector<std::string>& hosts, std::string_view before = {}) const {
    return gateway::browser_certificate(key, certificate, "shark", hosts, before);
  }
};

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

TEST_CASE("a key for browsers is made of the lab's key, and its certificate stays the same when it is kept") {
  const LabKey lab, other;
  const auto first = lab.for_browsers({"192.0.2.7", "lab.example"}),
             again = lab.for_browsers({"192.0.2.7", "lab.example"});
  CHECK(first.key_pem == again.key_pem);
  CHECK(first.key_pem != other.for_browsers({}).key_pem);
  CHECK(first.certificate_pem.starts_with("-----BEGIN CERTIFICATE-----"));
  CHECK(first.fingerprint.size() == 95);
  const auto kept = lab.for_browsers({"192.0.2.7", "lab.example"}, first.certificate_pem);
  CHECK(kept.certificate_pem == first.certificate_pem);
  CHECK(kept.fingerprint == first.fingerprint);
  CHECK(lab.for_browsers({"192.0.2.8"}, first.certificate_pem).certificate_pem != first.certificate_pem);
  CHECK(other.for_browsers({"192.0.2.7", "lab.example"}, first.certificate_pem).certificate_pem !=
        first.certificate_pem);
  CHECK(lab.for_browsers({}, "junk").certificate_pem.starts_with("-----BEGIN CERTIFICATE-----"));
  CHECK_NOTHROW(lab.for_browsers({"a,DNS:evil", "", "x y"}));
}

TEST_CASE("beyond loopback a page is served over TLS only, and Host and Origin count there, too") {
  const LabKey lab;
  const auto shown = lab.for_browsers({"127.0.0.1", "lab.example"});
  asio::io_context loop;
  NoDesk desk;
  view::Server server(loop,
                      {.address = "0.0.0.0",
                       .port = 0,
                       .hosts = {"lab.example"},
                       .identity = view::Identity{shown.key_pem, shown.certificate_pem}},
                      desk);
  const std::string port = std::to_string(server.port());
  CHECK(server.url() == "https://lab.example:" + port + "/");
  const auto status = [&](const std::string& headers) {
    return ask(loop, server.port(), shown.certificate_pem, "127.0.0.1", headers);
  };
  CHECK(status("Host: 127.0.0.1:" + port + "\r\n") == "HTTP/1.1 200 OK\r\n");
  CHECK(status("Host: lab.example:" + port + "\r\nOrigin: https://lab.example:" + port + "\r\n") ==
        "HTTP/1.1 200 OK\r\n");
  CHECK(status("Host: evil.example:" + port + "\r\n").starts_with("HTTP/1.1 403"));
  CHECK(status("Host: lab.example:" + port + "\r\nOrigin: http://lab.example:" + port + "\r\n")
            .starts_with("HTTP/1.1 403"));
  // Another lab's certificate is not this one's.
  CHECK(ask(loop, server.port(), LabKey().for_browsers({"127.0.0.1"}).certificate_pem, "127.0.0.1", "")
            .find("certificate verify failed") != std::string::npos);
  // Who speaks no TLS gets nothing.
  Browser plain(loop, server.port());
  CHECK(plain.ask("GET /about.json").empty());
  CHECK(comes_to(serving(loop), [&] { return server.counters()["view.sent_away.no_handshake"] >= 2; }));
}

}  // namespace
}  // namespace arkmesh::tests
