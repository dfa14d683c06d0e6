// The only source that compiles the WebSocket of Boost.Beast.
#include "view/connection.hpp"

#include <array>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

namespace arkmesh::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Monotonic = std::chrono::steady_clock;

constexpr std::chrono::seconds handshake_within{10}, request_within{10}, progress_within{20};
constexpr std::size_t kernel_buffer_bytes = 256 << 10;  // what is older than newest waits there, too
// Nothing but what this server gave; nobody else may show it in a frame of theirs.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> headers{{
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri "
     "'none'; form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
}};
constexpr hal::HttpLimits limits{.request_bytes = Connection::max_request_bytes,
                                 .body_bytes = Connection::max_body_bytes,
                                 .request_within = request_within,
                                 .progress_within = progress_within,
                                 .several = true,
                                 .headers = headers};

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
  BeastConnection(asio::ip::tcp::socket socket, asio::ssl::context* tls, Reception& reception)
      : Connection(std::move(socket), limits, tls), reception_(reception) {
    error_code ignored;
    stream_.socket().set_option(asio::ip::tcp::socket::send_buffer_size(kernel_buffer_bytes), ignored);
  }

  void send() override {
    if (!ws_ || !joined_ || writing_ || has_left()) return;
    auto next = outbox().take();
    if (!next) return;
    writing_ = std::move(next->bytes);
    ws_->text(next->text);
    wait_for(progress_within, "sent_away.takes_nothing");
    ws_->async_write(asio::buffer(*writing_), [self = self_()](error_code error, std::size_t) {
      self->writing_.reset();
      if (self->has_left()) return;
      if (error) return self->leave();
      self->timer_.cancel();
      self->send();
      if (self->paused_ && !self->outbox().busy()) self->read_message();
    });
  }

  bool sending() const override { return writing_ || !outbox().empty(); }

  void open() override {
    ws_.emplace(stream_);
    ws_->set_option(websocket::stream_base::timeout{handshake_within, std::chrono::seconds(60), true});
    ws_->read_message_max(max_message_bytes);
    ws_->binary(true);
    ws_->auto_fragment(false);
    // Beast reads on by itself after each ping and pong.
    ws_->control_callback([this](websocket::frame_type, beast::string_view) {
      if (controls_.add() == max_controls_per_s)
        asio::post(stream_.get_executor(), [self = self_()] { self->end("sent_away.garbage"); });
    });
    wait_for(handshake_within, "sent_away.no_handshake");
    ws_->async_accept(message(), [self = self_()](error_code error) {
      if (self->has_left()) return;
      if (error) return self->end("sent_away.no_handshake");
      self->timer_.cancel();
      self->joined_ = true;
      self->reception_.joined(*self);
      if (self->has_left()) return;
      self->send();
      self->read_message();
    });
  }

 private:
  std::shared_ptr<BeastConnection> self_() { return std::static_pointer_cast<BeastConnection>(shared_from_this()); }
  void asked(const hal::HttpRequest& request) override { reception_.asked(*this, request); }
  void leaves() override { reception_.left(*this); }
  void count(const std::string& what) override { reception_.counters().add("view." + what); }

  void read_message() {
    paused_ = false;
    ws_->async_read(said_, [self = self_()](error_code error, std::size_t) {
      if (!self->has_left()) self->heard(error);
    });
  }

  void heard(error_code error) {
    if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
      return end("sent_away.too_long");
    const bool broken =
        error.category() == asio::error::get_system_category() || error.category() == asio::error::get_misc_category();
    if (error && (broken || error == websocket::error::closed)) return leave();
    if (error == beast::error::timeout) return end("sent_away.silent");
    if (error) return end("sent_away.garbage");
    if (!ws_->got_text()) return end("sent_away.garbage");
    const auto bytes = said_.cdata();
    const Heard heard = reception_.said(*this, {static_cast<const char*>(bytes.data()), bytes.size()});
    if (has_left()) return;
    said_.consume(said_.size());
    if (!heard.good) return end("sent_away.garbage");
    send();
    if (heard.wait.count() == 0) return read_on();
    pause_.expires_after(heard.wait);
    pause_.async_wait([self = self_()](error_code ended) {
      if (!ended && !self->has_left()) self->read_on();
    });
  }

  // No faster than anybody needs: a flood is read slowly, and the kernel holds it up.
  void read_on() {
    if (outbox().busy()) {
      paused_ = true;
      return;
    }
    if (messages_.add() <= max_messages_per_s) return read_message();
    reception_.counters().add("view.late.too_many_messages");
    pause_.expires_at(messages_.end());
    pause_.async_wait([self = self_()](error_code error) {
      if (!error && !self->has_left()) self->read_on();
    });
  }

  Reception& reception_;
  std::optional<websocket::stream<hal::HttpStream&, false>> ws_;
  beast::flat_buffer said_{max_message_bytes};
  std::shared_ptr<const std::string> writing_;
  bool joined_ = false;
  bool paused_ = false;  // nothing is read until answers have gone
  ThisSecond messages_, controls_;
};

}  // namespace

std::shared_ptr<Connection> make_connection(asio::ip::tcp::socket socket, asio::ssl::context* tls,
                                            Reception& reception) {
  return std::make_shared<BeastConnection>(std::move(socket), tls, reception);
}

}  // namespace arkmesh::view
