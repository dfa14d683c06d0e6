// The bytes of an HTTP connection, in plain TCP or through TLS: one type, so that what reads HTTP and WebSocket is
// compiled once.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/bind_handler.hpp>
#include <boost/beast/core/role.hpp>
#include <optional>
#include <utility>

namespace arkmesh::hal {

class HttpStream {
 public:
  using executor_type = boost::asio::ip::tcp::socket::executor_type;
  using Error = boost::system::error_code;

  // `tls`: null for plain TCP; else it outlives the stream.
  HttpStream(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* tls) : socket_(std::move(socket)) {
    if (tls) tls_.emplace(socket_, *tls);
  }
  HttpStream(const HttpStream&) = delete;

  executor_type get_executor() { return socket_.get_executor(); }
  boost::asio::ip::tcp::socket& socket() { return socket_; }

  template <class Handler>
  void async_handshake(Handler&& handler) {
    if (tls_) return tls_->async_handshake(boost::asio::ssl::stream_base::server, std::forward<Handler>(handler));
    boost::asio::post(get_executor(), boost::beast::bind_front_handler(std::forward<Handler>(handler), Error{}));
  }
  template <class Buffers, class Handler>
  void async_read_some(const Buffers& into, Handler&& handler) {
    if (tls_) return tls_->async_read_some(into, std::forward<Handler>(handler));
    socket_.async_read_some(into, std::forward<Handler>(handler));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& from, Handler&& handler) {
    if (tls_) return tls_->async_write_some(from, std::forward<Handler>(handler));
    socket_.async_write_some(from, std::forward<Handler>(handler));
  }
  void close() {
    Error ignored;
    socket_.shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
    socket_.close(ignored);
  }

 private:
  boost::asio::ip::tcp::socket socket_;
  std::optional<boost::asio::ssl::stream<boost::asio::ip::tcp::socket&>> tls_;
};

// Called by Beast when a WebSocket took too long.
inline void beast_close_socket(HttpStream& stream) {
  stream.close();
}
// When one has been closed on both sides: nothing is left to be said.
inline void teardown(boost::beast::role_type, HttpStream& stream, boost::system::error_code& error) {
  stream.close();
  error = {};
}
template <class Handler>
void async_teardown(boost::beast::role_type, HttpStream& stream, Handler&& handler) {
  stream.close();
  boost::asio::post(stream.get_executor(),
                    boost::beast::bind_front_handler(std::forward<Handler>(handler), boost::system::error_code{}));
}

}  // namespace arkmesh::hal
