// What Prometheus reads of a gateway, and who may ask.
#include "gateway/metrics.hpp"

#include <doctest/doctest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <string>
#include <vector>

#include "gateway/metrics_server.hpp"
#include "tests/support/network/tcp_bench.hpp"

namespace arkmesh::gateway {
namespace {

using boost::asio::ip::tcp;

TEST_CASE("a gateway's numbers are what Prometheus reads") {
  // A name twice, a level and a total, a text of a peer that would break the format, a clock that is not known.
  peer_t peer;
  peer.lab = "roark";
  peer.up = 1;
  peer.round_trip_us = 1500;
  peer.clock_offset_us = -2'000'000;
  peer.clock_uncertainty_us = 750;
  peer.channels = {{.channel = "roark/\"world\"\n", .age_us = 250'000, .messages = 7, .bytes = 700}};
  peer.counters = {{.name = "outbox.waiting.messages", .value = 3}, {.name = "session.opened", .value = 2}};
  peer_t unknown;
  unknown.lab = "lynx";
  unknown.up = 0;
  unknown.round_trip_us = -1;
  peers_t peers;
  peers.lab = "shark";
  peers.peers = {peer, unknown};
  const std::string text = to_metrics(peers);
  for (const char* line :
       {"# TYPE arkmesh_peer_up gauge\n", "\narkmesh_peer_up{lab=\"shark\",peer=\"roark\"} 1\n",
        "\narkmesh_peer_up{lab=\"shark\",peer=\"lynx\"} 0\n",
        "\narkmesh_peer_round_trip_seconds{lab=\"shark\",peer=\"roark\"} 0.0015\n",
        "\narkmesh_peer_clock_offset_seconds{lab=\"shark\",peer=\"roark\"} -2\n",
        "\narkmesh_channel_messages_total{lab=\"shark\",peer=\"roark\",channel=\"roark/\\\"world\\\"",
        "\narkmesh_peer_level{lab=\"shark\",peer=\"roark\",name=\"outbox.waiting.messages\"} 3\n",
        "\narkmesh_peer_events_total{lab=\"shark\",peer=\"roark\",name=\"session.opened\"} 2\n"}) {
    CAPTURE(line);
    CHECK(text.find(line) != std::string::npos);
  }
  CHECK(text.find("round_trip_seconds{lab=\"shark\",peer=\"lynx\"}") == std::string::npos);
  CHECK(text.find("gateway_events_total") == std::string::npos);
}

struct Asking {
  tcp::socket socket;
  std::string answer;
  bool over = false;

  Asking(boost::asio::io_context& io, const tcp::endpoint& to) : socket(io) { socket.connect(to); }
  void ask(const std::string& request) {
    boost::system::error_code gone;
    boost::asio::write(socket, boost::asio::buffer(request), gone);
    boost::asio::async_read(socket, boost::asio::dynamic_buffer(answer), [this](auto, std::size_t) { over = true; });
  }
};

TEST_CASE("metrics are given to who asks for them") {
  // Each time anew; not for another path, an endless request, or to more than a few at a time, who are counted.
  boost::asio::io_context io;
  int asked = 0;
  MetricsServer server(io, {boost::asio::ip::address_v4::loopback(), 0},
                       [&] { return "asked " + std::to_string(++asked) + "\n"; });
  const auto get = [&](const std::string& request) {
    Asking client(io, server.listening());
    client.ask(request);
    CHECK(tests::run_until(io, [&] { return client.over; }));
    return client.answer;
  };
  CHECK(get("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n").ends_with("\r\n\r\nasked 1\n"));
  CHECK(get("GET /metrics HTTP/1.0\r\n\r\n").ends_with("asked 2\n"));
  CHECK(get("GET /secrets HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404"));
  CHECK(get("GET /" + std::string(10'000, 'x') + " HTTP/1.1\r\n\r\n").find("200 OK") == std::string::npos);
  CHECK(get("\x16\x03\x01nonsense\r\n\r\n").find("200 OK") == std::string::npos);
  std::vector<std::unique_ptr<Asking>> idle;
  for (int i = 0; i < 8; ++i) idle.push_back(std::make_unique<Asking>(io, server.listening()));
  CHECK(get("GET /metrics HTTP/1.1\r\n\r\n").empty());
  idle.clear();
  CHECK(tests::run_until(io, [&] { return get("GET /metrics HTTP/1.1\r\n\r\n").ends_with("asked 3\n"); }));
  CHECK(asked == 3);
  CHECK(server.counters()["metrics.refused.too_many"] >= 1);
  CHECK(server.counters()["metrics.refused.request"] >= 3);
}

}  // namespace
}  // namespace arkmesh::gateway
