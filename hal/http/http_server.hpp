// One HTTP server for all that speaks HTTP: the page of a lab, live pictures, metrics. Accepts connections, reads
// requests and writes answers; what is answered is up to who derives from HttpConnection. What a connection can hold is
// bounded, and one that is too slow, or sends too much, is ended with the reason counted. Works while the event loop
// runs; nothing here blocks, and there is no thread. A target of its own, arkmesh::http: it needs OpenSSL.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/http/http_stream.hpp"

namespace arkmesh::hal {

// What a client asks for. Headers that it did not send are empty.
struct HttpRequest {
  std::string_view method, path, host, origin, cookie, body;  // path: without what follows a '?'
  std::string_view reached;                                   // the address of this machine that it came to
  bool upgrade = false;                                       // wants a WebSocket
};

struct HttpReply {
  unsigned status = 200;
  std::string_view type = "text/plain; charset=utf-8";
  std::string body;
  std::vector<std::pair<std::string_view, std::string>> headers;  // beside those that each answer has
};

struct HttpLimits {
  std::size_t request_bytes = 4096, body_bytes = 0;  // body_bytes 0: bodies are not read
  std::chrono::seconds request_within{5};            // from connecting, also for the handshake of TLS by itself
  std::chrono::seconds progress_within{10};          // for an answer to be taken
  bool several = false;                              // requests on one connection, one after another
  std::span<const std::pair<std::string_view, std::string_view>> headers;  // of each answer
};

// One connection. The loop keeps it while something is on its way; it does nothing more once it has left.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  virtual ~HttpConnection() = default;
  // Ends it at once.
  void leave();
  bool has_left() const { return left_; }
  // To what it asked; once for each request.
  void answer(HttpReply reply);
  // So much later, with what `make` gives then; not at all when answer() was called before.
  void answer_later(std::chrono::milliseconds after, std::function<HttpReply()> make);

  boost::asio::ip::address from;

 protected:
  // `limits` and `tls` outlive it; `tls` is null for plain TCP.
  HttpConnection(boost::asio::ip::tcp::socket socket, const HttpLimits& limits, boost::asio::ssl::context* tls);

  // It has asked; `request` is good until it is answered.
  virtual void asked(const HttpRequest& request) = 0;
  // Refused or ended, and why: "refused.request_too_long", "refused.no_http"; "sent_away.no_handshake", ".no_request",
  // ".takes_nothing", or what was given to end().
  virtual void count(const std::string& what) = 0;
  // The last call.
  virtual void leaves() {}

  // Counts why, and leaves.
  void end(const std::string& why);
  // Then it is ended; with no reason it just leaves. A later call, or timer_.cancel(), takes its place.
  void wait_for(std::chrono::seconds time, const char* why);
  const boost::beast::http::request<boost::beast::http::string_body>& message() const { return parser_->get(); }

  HttpStream stream_;
  boost::asio::steady_timer timer_, pause_;
  const HttpLimits& limits_;

 private:
  friend class HttpServer;
  void start();
  void read_request();
  void read(boost::system::error_code error);
  void refuse(unsigned status, const char* why, const char* sentence);

  std::function<void(HttpConnection&)> forget_;  // its server's
  std::string reached_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  boost::beast::http::response<boost::beast::http::string_body> response_;
  bool keep_alive_ = false, served_ = false, left_ = false;
};

class HttpServer {
 public:
  // Makes the object of one more connection; null when there is no room for it.
  using Welcome = std::function<std::shared_ptr<HttpConnection>(boost::asio::ip::tcp::socket)>;

  // Accepts from now on.
  HttpServer(boost::asio::ip::tcp::acceptor acceptor, Welcome welcome);
  // All connections leave.
  ~HttpServer();
  boost::asio::ip::tcp::endpoint listening() const;
  const std::set<std::shared_ptr<HttpConnection>>& connections() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the loop's next call, which looks whether it still lives
};

}  // namespace arkmesh::hal
