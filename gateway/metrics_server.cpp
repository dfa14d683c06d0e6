#include "gateway/metrics_server.hpp"

#include <chrono>
#include <utility>

#include "hal/http/http_server.hpp"
#include "hal/listen.hpp"

namespace arkmesh::gateway {
namespace {

using boost::asio::ip::tcp;

constexpr std::size_t max_clients = 8;
constexpr hal::HttpLimits limits{.progress_within = std::chrono::seconds(5)};

}  // namespace

struct MetricsServer::State {
  struct Client final : hal::HttpConnection {
    Client(tcp::socket socket, State& all) : HttpConnection(std::move(socket), limits, nullptr), state(all) {}
    void asked(const hal::HttpRequest& request) override {
      served = request.method == "GET" && request.path == "/metrics";
      if (!served) return answer({.status = 404, .body = "GET /metrics\n"});
      state.counters.add("metrics.served");
      answer({.type = "text/plain; version=0.0.4", .body = state.text()});
    }
    void count(const std::string&) override {}  // one word says it all:
    void leaves() override {
      if (!served) state.counters.add("metrics.refused.request");
    }
    State& state;
    bool served = false;
  };

  State(boost::asio::io_context& io, const tcp::endpoint& here, std::function<std::string()> make)
      : text(std::move(make)),
        server(hal::listen_on(io, here.address().to_string(), here.port(), "metrics"),
               [this](tcp::socket socket) { return take(std::move(socket)); }) {}

  std::shared_ptr<hal::HttpConnection> take(tcp::socket socket) {
    if (server.connections().size() < max_clients) return std::make_shared<Client>(std::move(socket), *this);
    counters.add("metrics.refused.too_many");
    return nullptr;
  }

  std::function<std::string()> text;
  hal::Counters counters;
  hal::HttpServer server;
};

MetricsServer::MetricsServer(boost::asio::io_context& io, const tcp::endpoint& here, std::function<std::string()> text)
    : state_(std::make_unique<State>(io, here, std::move(text))) {}
MetricsServer::~MetricsServer() = default;

tcp::endpoint MetricsServer::listening() const {
  return state_->server.listening();
}

const hal::Counters& MetricsServer::counters() const {
  return state_->counters;
}

}  // namespace arkmesh::gateway
