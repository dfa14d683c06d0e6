// The only source that compiles Boost.Beast.
#include "view/connection.hpp"

#include <fcntl.h>

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/flat_static_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>
#include <utility>

#include "view/stream.hpp"

namespace arkmesh::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using Monotonic = std::chrono::steady_clock;

constexpr std::chrono::seconds handshake_within{10}, request_within{10}, progress_within{20};
constexpr std::size_t kernel_buffer_bytes = 256 << 10;  // what is older than newest waits there, too
// Nothing but what this server gave; nobody else may show it in a frame of theirs.
constexpr std::string_view policy =
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri "
    "'none'; "
    "form-action 'none'; frame-ancestors 'none'";

std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}

// How many of something came in this second.
class ThisSecond {
 public:
  int add() {
    if (const auto now = Monotonic::now(); now >= end()) begin_ = now, count_ = 0;
    return ++count_;
  }
  Monotonic::time_point end() const { return begin_ + std::chrono::seconds(1); }

 private:
  Monotonic::time_point begin_{};
  int count_ = 0;
};

class BeastConnection final : public Connection {
 public:
  BeastConnection(tcp::socket socket, asio::ssl::context* tls, Reception& reception)
      : stream_(std::move(socket), tls),
        reception_(&reception),
        timer_(stream_.get_executor()),
        pause_(stream_.get_executor()) {
    ::fcntl(stream_.socket().native_handle(), F_SETFD, FD_CLOEXEC);
    error_code ignored;
    stream_.socket().set_option(tcp::no_delay(true), ignored);
    stream_.socket().set_option(tcp::socket::send_buffer_size(kernel_buffer_bytes), ignored);
    from = stream_.socket().remote_endpoint(ignored).address();
    const auto here = stream_.socket().local_endpoint(ignored).address();
    reached_ = here.is_v6() && here.to_v6().is_v4_mapped()
                   ? asio::ip::make_address_v4(asio::ip::v4_mapped, here.to_v6()).to_string()
                   : here.to_string();
  }

  void start() override {
    wait_for(handshake_within, "no_handshake");
    stream_.async_handshake([self = self_()](error_code error) {
      if (!self->reception_) return;
      if (error) return self->end("no_handshake");
      self->read_request();
    });
  }

  void send() override {
    if (!ws_ || !joined_ || writing_ || !reception_) return;
    auto next = outbox().take();
    if (!next) return;
    writing_ = std::move(next->bytes);
    ws_->text(next->text);
    wait_for(progress_within, "takes_nothing");
    ws_->async_write(asio::buffer(*writing_), [self = self_()](error_code error, std::size_t) {
      self->writing_.reset();
      if (!self->reception_) return;
      if (error) return self->leave();
      self->timer_.cancel();
      self->send();
      if (self->paused_ && !self->outbox().busy()) self->read_message();
    });
  }

  bool sending() const override { return writing_ || !outbox().empty(); }

  void leave() override {
    if (!reception_) return;
    Reception& reception = *std::exchange(reception_, nullptr);
    timer_.cancel();
    pause_.cancel();
    stream_.close();
    reception.left(*this);
  }

 private:
  std::shared_ptr<BeastConnection> self_() { return std::static_pointer_cast<BeastConnection>(shared_from_this()); }

  void end(std::string_view why) {
    if (reception_) reception_->counters().add("view.sent_away." + std::string(why));
    leave();
  }

  // Then it is ended; with no reason when it may be silent for long.
  void wait_for(std::chrono::seconds time, const char* why) {
    timer_.expires_after(time);
    timer_.async_wait([self = self_(), why](error_code error) {
      // one that was set anew meanwhile may have been on its way already
      if (!error && self->timer_.expiry() <= Monotonic::now()) why ? self->end(why) : self->leave();
    });
  }

  void read_request() {
    parser_.emplace();
    parser_->header_limit(max_request_bytes);
    parser_->body_limit(max_body_bytes);
    wait_for(request_within, served_ ? nullptr : "no_request");
    http::async_read(stream_, buffer_, *parser_, [self = self_()](error_code error, std::size_t) {
      if (self->reception_) self->asked(error);
    });
  }

  void asked(error_code error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow || error == http::error::body_limit)
      return refuse(431, "request_too_long", "The request is too long.\n");
    if (error == http::error::end_of_stream || error == http::error::partial_message) return leave();
    if (error && error.category() == error_code(http::error::bad_method).category())
      return refuse(400, "no_http", "This is no HTTP request.\n");
    if (error) return leave();
    served_ = true;
    const auto& message = parser_->get();
    const auto header = [&](http::field name) { return view_of(message[name]); };
    Request request{.method = view_of(message.method_string()),
                    .path = view_of(message.target()),
                    .host = header(http::field::host),
                    .origin = header(http::field::origin),
                    .cookie = header(http::field::cookie),
                    .body = message.body(),
                    .reached = reached_,
                    .upgrade = websocket::is_upgrade(message)};
    request.path = request.path.substr(0, request.path.find('?'));
    if (message.count(http::field::host) > 1 || message.count(http::field::origin) > 1)
      return refuse(400, "no_http", "The request has a header twice.\n");
    if (!request.upgrade) return answer(reception_->reply_to(*this, request), message.keep_alive());
    Reply verdict = reception_->admit(*this, request);
    if (verdict.status != 101) return answer(std::move(verdict), false);
    accept();
  }

  void refuse(int status, std::string_view why, std::string_view sentence) {
    reception_->counters().add("view.refused." + std::string(why));
    answer({.status = status, .body = std::string(sentence)}, false);
  }

  void answer(Reply reply, bool keep_alive) {
    if (const auto after = std::exchange(reply.after, {}); after.count() > 0) {
      wait_for(progress_within, "takes_nothing");
      pause_.expires_after(after);
      return pause_.async_wait([self = self_(), reply = std::move(reply), keep_alive](error_code error) mutable {
        if (!error && self->reception_) self->answer(std::move(reply), keep_alive);
      });
    }
    response_ = {};
    response_.version(11);
    response_.result(static_cast<unsigned>(reply.status));
    response_.set(http::field::content_type, {reply.type.data(), reply.type.size()});
    response_.set(http::field::cache_control, "no-store");
    response_.set("Content-Security-Policy", {policy.data(), policy.size()});
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("Cross-Origin-Resource-Policy", "same-origin");
    if (!reply.set_cookie.empty()) response_.set(http::field::set_cookie, reply.set_cookie);
    if (reply.status == 405) response_.set(http::field::allow, "GET, HEAD");
    response_.keep_alive(keep_alive);
    response_.body() = std::move(reply.body);
    response_.prepare_payload();
    // To HEAD everything but the body.
    if (parser_->is_header_done() && parser_->get().method() == http::verb::head) response_.body().clear();
    wait_for(progress_within, "takes_nothing");
    http::async_write(stream_, response_, [self = self_(), keep_alive](error_code error, std::size_t) {
      if (!self->reception_) return;
      if (error || !keep_alive) return self->leave();
      self->read_request();
    });
  }

  void accept() {
    ws_.emplace(stream_);
    ws_->set_option(websocket::stream_base::timeout{handshake_within, std::chrono::seconds(60), true});
    ws_->read_message_max(max_message_bytes);
    ws_->binary(true);
    ws_->auto_fragment(false);
    // Beast reads on by itself after each ping and pong.
    ws_->control_callback([this](websocket::frame_type, beast::string_view) {
      if (controls_.add() == max_controls_per_s)
        asio::post(stream_.get_executor(), [self = self_()] { self->end("garbage"); });
    });
    wait_for(handshake_within, "no_handshake");
    ws_->async_accept(parser_->get(), [self = self_()](error_code error) {
      if (!self->reception_) return;
      if (error) return self->end("no_handshake");
      self->timer_.cancel();
      self->joined_ = true;
      const auto& message = self->parser_->get();
      self->reception_->joined(*self, {.cookie = view_of(message[http::field::cookie])});
      if (!self->reception_) return;
      self->parser_.reset();
      self->send();
      self->read_message();
    });
  }

  void read_message() {
    paused_ = false;
    ws_->async_read(said_, [self = self_()](error_code error, std::size_t) {
      if (self->reception_) self->heard(error);
    });
  }

  void heard(error_code error) {
    if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
      return end("too_long");
    const bool broken =
        error.category() == asio::error::get_system_category() || error.category() == asio::error::get_misc_category();
    if (error && (broken || error == websocket::error::closed)) return leave();
    if (error == beast::error::timeout) return end("silent");
    if (error) return end("garbage");
    if (!ws_->got_text()) return end("garbage");
    const auto bytes = said_.cdata();
    const Heard heard = reception_->said(*this, {static_cast<const char*>(bytes.data()), bytes.size()});
    if (!reception_) return;
    said_.consume(said_.size());
    if (!heard.good) return end("garbage");
    send();
    if (heard.wait.count() == 0) return read_on();
    pause_.expires_after(heard.wait);
    pause_.async_wait([self = self_()](error_code ended) {
      if (!ended && self->reception_) self->read_on();
    });
  }

  // No faster than anybody needs: a flood is read slowly, and the kernel holds it up.
  void read_on() {
    if (outbox().busy()) {
      paused_ = true;
      return;
    }
    if (messages_.add() <= max_messages_per_s) return read_message();
    reception_->counters().add("view.late.too_many_messages");
    pause_.expires_at(messages_.end());
    pause_.async_wait([self = self_()](error_code error) {
      if (!error && self->reception_) self->read_on();
    });
  }

  Stream stream_;
  Reception* reception_;  // null: it has left
  asio::steady_timer timer_, pause_;
  std::string reached_;
  beast::flat_static_buffer<max_request_bytes + max_body_bytes> buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> response_;
  std::optional<websocket::stream<Stream&, false>> ws_;
  beast::flat_buffer said_{max_message_bytes};
  std::shared_ptr<const std::string> writing_;
  bool served_ = false, joined_ = false;
  bool paused_ = false;  // nothing is read until answers have gone
  ThisSecond messages_, controls_;
};

}  // namespace

std::shared_ptr<Connection> make_connection(tcp::socket socket, asio::ssl::context* tls, Reception& reception) {
  return std::make_shared<BeastConnection>(std::move(socket), tls, reception);
}

}  // namespace arkmesh::view
