// Serves a text over HTTP to programs of this machine: GET /metrics, for Prometheus.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string>

#include "hal/counters.hpp"

namespace arkmesh::gateway {

// One request for each connection. At most 8 connections at a time, 5 s and 4 KiB of request each; more are refused and
// counted. Works while the loop runs; nothing blocks.
class MetricsServer {
 public:
  // `io` outlives the server; `text` is called for each request. Throws std::runtime_error with one sentence when the
  // port is taken.
  MetricsServer(boost::asio::io_context& io, const boost::asio::ip::tcp::endpoint& here,
                std::function<std::string()> text);
  ~MetricsServer();
  // Where; port 0 was replaced by the one that the system chose.
  boost::asio::ip::tcp::endpoint listening() const;
  // metrics.served, metrics.refused.too_many, metrics.refused.request.
  const hal::Counters& counters() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::gateway
