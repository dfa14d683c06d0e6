// Boost.Beast reads requests and writes answers; its stream keeps the time limit.
#include "gateway/metrics_server.hpp"

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_static_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <utility>

#include "hal/listen.hpp"

namespace arkmesh::gateway {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t max_clients = 8, max_request_bytes = 4096;
constexpr std::chrono::seconds within{5};
constexpr std::chrono::milliseconds accept_again_after{100};

}  // namespace

struct MetricsServer::State : std::enable_shared_from_this<State> {
  // Lives as long as something of it is under way.
  struct Client : std::enable_shared_from_this<Client> {
    Client(tcp::socket socket, std::weak_ptr<State> server) : stream(std::move(socket)), state(std::move(server)) {}
    ~Client() {
      if (const auto server = state.lock()) --server->clients;
    }
    void serve() {
      parser.header_limit(max_request_bytes);
      stream.expires_after(within);
      http::async_read_header(stream, buffer, parser, [self = shared_from_this()](error_code error, std::size_t) {
        if (const auto server = self->state.lock()) self->answer(*server, error);
      });
    }
    void answer(State& server, error_code error) {
      const bool wanted = !error && parser.get().method() == http::verb::get && parser.get().target() == "/metrics";
      server.counters.add(wanted ? "metrics.served" : "metrics.refused.request");
      if (error) return;
      response.version(11);
      response.keep_alive(false);
      response.result(wanted ? http::status::ok : http::status::not_found);
      response.set(http::field::content_type, "text/plain; version=0.0.4");
      response.body() = wanted ? server.text() : "GET /metrics\n";
      response.prepare_payload();
      http::async_write(stream, response, [self = shared_from_this()](error_code, std::size_t) {
        error_code ignored;
        self->stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
      });
    }

    beast::tcp_stream stream;
    std::weak_ptr<State> state;
    beast::flat_static_buffer<max_request_bytes> buffer;
    http::request_parser<http::empty_body> parser;
    http::response<http::string_body> response;
  };

  State(asio::io_context& io, const tcp::endpoint& here, std::function<std::string()> make)
      : acceptor(hal::listen_on(io, here.address().to_string(), here.port(), "metrics")),
        again(io),
        text(std::move(make)) {}

  void accept() {
    acceptor.async_accept([weak = weak_from_this()](error_code error, tcp::socket socket) {
      const auto self = weak.lock();
      if (!self || error == asio::error::operation_aborted) return;
      if (error) return self->accept_later();
      if (self->clients >= max_clients) {
        self->counters.add("metrics.refused.too_many");
      } else {
        ++self->clients;
        std::make_shared<Client>(std::move(socket), weak)->serve();
      }
      self->accept();
    });
  }

  // Without a file descriptor to spare, say.
  void accept_later() {
    again.expires_after(accept_again_after);
    again.async_wait([weak = weak_from_this()](error_code error) {
      if (const auto self = weak.lock(); self && !error) self->accept();
    });
  }

  tcp::acceptor acceptor;
  asio::steady_timer again;
  std::function<std::string()> text;
  std::size_t clients = 0;
  hal::Counters counters;
};

MetricsServer::MetricsServer(asio::io_context& io, const tcp::endpoint& here, std::function<std::string()> text)
    : state_(std::make_shared<State>(io, here, std::move(text))) {
  state_->accept();
}
MetricsServer::~MetricsServer() = default;

tcp::endpoint MetricsServer::listening() const {
  error_code not_open;
  return state_->acceptor.local_endpoint(not_open);
}

const hal::Counters& MetricsServer::counters() const {
  return state_->counters;
}

}  // namespace arkmesh::gateway
