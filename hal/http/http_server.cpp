#include "hal/http/http_server.hpp"

#include <fcntl.h>

#include <boost/asio/post.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

namespace arkmesh::hal {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;
using Monotonic = std::chrono::steady_clock;

constexpr std::chrono::milliseconds accept_again_after{100};

std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}
beast::string_view for_beast(std::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace

HttpConnection::HttpConnection(tcp::socket socket, const HttpLimits& limits, asio::ssl::context* tls)
    : stream_(std::move(socket), tls),
      timer_(stream_.get_executor()),
      pause_(stream_.get_executor()),
      limits_(limits),
      buffer_(limits.request_bytes + limits.body_bytes) {
  ::fcntl(stream_.socket().native_handle(), F_SETFD, FD_CLOEXEC);
  error_code ignored;
  stream_.socket().set_option(tcp::no_delay(true), ignored);
  from = stream_.socket().remote_endpoint(ignored).address();
  const auto here = stream_.socket().local_endpoint(ignored).address();
  reached_ = here.is_v6() && here.to_v6().is_v4_mapped()
                 ? asio::ip::make_address_v4(asio::ip::v4_mapped, here.to_v6()).to_string()
                 : here.to_string();
}

void HttpConnection::start() {
  wait_for(limits_.request_within, "sent_away.no_handshake");
  stream_.async_handshake([this, self = shared_from_this()](error_code error) {
    if (left_) return;
    if (error) return end("sent_away.no_handshake");
    read_request();
  });
}

void HttpConnection::leave() {
  if (std::exchange(left_, true)) return;
  const auto self = shared_from_this();
  timer_.cancel();
  pause_.cancel();
  stream_.close();
  if (forget_) forget_(*this);
  leaves();
}

void HttpConnection::end(const std::string& why) {
  if (left_) return;
  count(why);
  leave();
}

void HttpConnection::wait_for(std::chrono::seconds time, const char* why) {
  timer_.expires_after(time);
  timer_.async_wait([this, why, self = shared_from_this()](error_code error) {
    // one that was set anew meanwhile may have been on its way already
    if (!error && timer_.expiry() <= Monotonic::now()) why ? end(why) : leave();
  });
}

void HttpConnection::read_request() {
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(limits_.request_bytes));
  wait_for(limits_.request_within, served_ ? nullptr : "sent_away.no_request");
  auto then = [this, self = shared_from_this()](error_code error, std::size_t) { read(error); };
  if (limits_.body_bytes == 0) return http::async_read_header(stream_, buffer_, *parser_, std::move(then)), void();
  parser_->body_limit(limits_.body_bytes);
  http::async_read(stream_, buffer_, *parser_, std::move(then));
}

void HttpConnection::read(error_code error) {
  if (left_) return;
  keep_alive_ = false;
  if (error == http::error::header_limit || error == http::error::buffer_overflow || error == http::error::body_limit)
    return refuse(431, "refused.request_too_long", "The request is too long.\n");
  if (error == http::error::end_of_stream || error == http::error::partial_message) return leave();
  if (error && error.category() == error_code(http::error::bad_method).category())
    return refuse(400, "refused.no_http", "This is not an HTTP request.\n");
  if (error) return leave();
  served_ = true;
  if (message().count(http::field::host) > 1 || message().count(http::field::origin) > 1)
    return refuse(400, "refused.no_http", "The request repeats a header.\n");
  const auto header = [&](http::field name) { return view_of(message()[name]); };
  HttpRequest request{.method = view_of(message().method_string()),
                      .path = view_of(message().target()),
                      .host = header(http::field::host),
                      .origin = header(http::field::origin),
                      .cookie = header(http::field::cookie),
                      .body = message().body(),
                      .reached = reached_,
                      .upgrade = beast::websocket::is_upgrade(message())};
  request.path = request.path.substr(0, request.path.find('?'));
  keep_alive_ = limits_.several && !request.upgrade && message().keep_alive();
  asked(request);
}

void HttpConnection::refuse(unsigned status, const char* why, const char* sentence) {
  count(why);
  answer({.status = status, .body = sentence});
}

void HttpConnection::answer_later(std::chrono::milliseconds after, std::function<HttpReply()> make) {
  timer_.cancel();
  pause_.expires_after(after);
  pause_.async_wait([this, self = shared_from_this(), make = std::move(make)](error_code error) {
    if (!error && !left_ && pause_.expiry() <= Monotonic::now()) answer(make());
  });
}

void HttpConnection::answer(HttpReply reply) {
  pause_.expires_at(Monotonic::time_point::max());  // the later one does not come
  response_ = {};
  response_.version(11);
  response_.result(reply.status);
  response_.set(http::field::content_type, for_beast(reply.type));
  response_.set(http::field::cache_control, "no-store");
  for (const auto& [name, value] : limits_.headers) response_.set(for_beast(name), for_beast(value));
  for (const auto& [name, value] : reply.headers) response_.set(for_beast(name), value);
  response_.keep_alive(keep_alive_);
  response_.body() = std::move(reply.body);
  response_.prepare_payload();
  // To HEAD everything but the body.
  if (parser_->is_header_done() && message().method() == http::verb::head) response_.body().clear();
  wait_for(limits_.progress_within, "sent_away.takes_nothing");
  http::async_write(stream_, response_, [this, self = shared_from_this()](error_code error, std::size_t) {
    if (left_) return;
    if (error || !keep_alive_) return leave();
    read_request();
  });
}

struct HttpServer::State : std::enable_shared_from_this<State> {
  State(tcp::acceptor at, Welcome how)
      : acceptor(std::move(at)), again(acceptor.get_executor()), welcome(std::move(how)) {}

  void accept() {
    acceptor.async_accept([weak = weak_from_this()](error_code error, tcp::socket socket) {
      const auto self = weak.lock();
      if (!self || error == asio::error::operation_aborted) return;
      if (error) return self->accept_later();
      // those who have left make room for those who come
      asio::post(self->acceptor.get_executor(), [weak, socket = std::move(socket)]() mutable {
        const auto later = weak.lock();
        if (!later) return;
        later->take(std::move(socket));
        later->accept();
      });
    });
  }

  void take(tcp::socket socket) {
    const auto made = welcome(std::move(socket));
    if (!made) return;
    connections.insert(made);
    made->forget_ = [this](HttpConnection& gone) { connections.erase(gone.shared_from_this()); };
    made->start();
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
  Welcome welcome;
  std::set<std::shared_ptr<HttpConnection>> connections;
};

HttpServer::HttpServer(tcp::acceptor acceptor, Welcome welcome)
    : state_(std::make_shared<State>(std::move(acceptor), std::move(welcome))) {
  state_->accept();
}

HttpServer::~HttpServer() {
  while (!state_->connections.empty()) {
    const auto first = *state_->connections.begin();
    first->leave();
  }
}

tcp::endpoint HttpServer::listening() const {
  error_code not_open;
  return state_->acceptor.local_endpoint(not_open);
}

const std::set<std::shared_ptr<HttpConnection>>& HttpServer::connections() const {
  return state_->connections;
}

}  // namespace arkmesh::hal
