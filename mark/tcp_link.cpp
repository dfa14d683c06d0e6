#include "mark/tcp_link.hpp"

#include <fmt/format.h>
#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <optional>
#include <utility>

#include "hal/listen.hpp"

namespace arkmesh::mark {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using Error = boost::system::error_code;

constexpr auto try_again = 200ms;
constexpr const char* port_is_for = "the original M-ARK client (mark.port)";
constexpr std::size_t read_at_once = 16 << 10;  // in one serve(), so that a flood keeps nobody from his work

class TcpLink final : public Link {
 public:
  TcpLink(hal::EventLoop& loop, const Settings& s, Role role)
      : state_(std::make_shared<State>(loop)),
        address_(s.address == "localhost" ? "127.0.0.1" : s.address),
        port_(s.port),
        role_(role) {}
  ~TcpLink() override {
    Error ignored;
    state_->alive = false;
    state_->socket.close(ignored);
    if (state_->acceptor) state_->acceptor->close(ignored);
    state_->timer.cancel(ignored);
  }

  void start(Events& events) override {
    events_ = &events;
    // Taken, so that a port in use is told at once. A port that listens would already take an original.
    if (role_ == Role::server) state_->acceptor = hal::take_port(state_->loop, address_, port_, port_is_for);
  }
  void open() override {
    state_->acceptor.reset();
    role_ == Role::server ? listen() : connect();
  }

  void serve() override {
    State& s = *state_;
    if (std::exchange(s.came, false)) come();
    if (std::exchange(s.again, false)) go_on();
    if (!up_ || !std::exchange(s.readable, false)) return;
    std::array<char, 4096> bytes;
    for (std::size_t all = 0; up_ && all < read_at_once;) {
      Error error;
      const std::size_t n = s.socket.read_some(boost::asio::buffer(bytes), error);
      if (error == boost::asio::error::would_block) break;
      if (error) return lose(error == boost::asio::error::eof ? "it closed its connection" : error.message());
      all += n;
      events_->heard({bytes.data(), n});
    }
    if (up_) watch();
  }
  hal::TimePoint next_service() const override { return hal::TimePoint::max(); }  // what comes wakes the loop
  bool up() const override { return up_; }

  bool settled() const override {
    int waiting = 0;
    return up_ && rest_.empty() && ::ioctl(state_->socket.native_handle(), SIOCOUTQ, &waiting) == 0 && waiting == 0;
  }
  void send(std::string_view message) override {
    rest_ = message;
    write_rest();
  }
  std::string place() const override { return fmt::format("{}:{}", address_, port_); }
  std::string error() const override { return error_; }

 private:
  // What the loop's handlers touch; they may come after the link has died.
  struct State {
    explicit State(hal::EventLoop& l) : loop(l), socket(l), timer(l) {}
    hal::EventLoop& loop;
    tcp::socket socket;
    std::optional<tcp::acceptor> acceptor;
    boost::asio::steady_timer timer;
    bool alive = true, came = false, again = false, readable = false;
    std::string error;
  };

  void listen() {
    State& s = *state_;
    s.socket = tcp::socket(s.loop);
    s.acceptor = hal::listen_on(s.loop, address_, port_, port_is_for);
    s.acceptor->async_accept(s.socket, [state = state_](Error error) {
      if (!state->alive) return;
      // It takes exactly one, as the original server does.
      state->acceptor.reset();
      error ? state->again = true : state->came = true;
    });
  }

  void connect() {
    State& s = *state_;
    s.socket = tcp::socket(s.loop);
    s.socket.async_connect({boost::asio::ip::make_address(address_), port_}, [state = state_](Error error) {
      if (!state->alive) return;
      Error none;
      // A port that nobody listens on may connect to itself.
      const bool itself = !error && state->socket.local_endpoint(none) == state->socket.remote_endpoint(none);
      if (!error && !itself) {
        state->came = true;
        return;
      }
      state->error = itself ? "nobody listens there" : error.message();
      wait(state);
    });
  }

  // After a loss, or in vain.
  void go_on() {
    if (up_) return;
    if (!state_->error.empty()) error_ = std::exchange(state_->error, {});
    try {
      role_ == Role::server ? listen() : connect();
    } catch (const std::exception& error) {
      error_ = error.what();
      wait(state_);
    }
  }

  static void wait(const std::shared_ptr<State>& state) {
    state->timer.expires_after(try_again);
    state->timer.async_wait([state](Error cancelled) { state->again = !cancelled; });
  }

  void come() {
    Error error;
    state_->socket.set_option(tcp::no_delay(true), error);
    state_->socket.non_blocking(true, error);
    // A machine that went without a word says so when it is back. A cable may be out for ten minutes before: the end of
    // the connection would kill an original at its other end.
    state_->socket.set_option(tcp::socket::keep_alive(true), error);
    for (const auto& [name, value] : {std::pair{TCP_KEEPIDLE, 10}, {TCP_KEEPINTVL, 10}, {TCP_KEEPCNT, 60}})
      ::setsockopt(state_->socket.native_handle(), IPPROTO_TCP, name, &value, sizeof value);
    up_ = true;
    error_.clear();
    rest_.clear();
    events_->came();
    watch();
  }

  void watch() {
    state_->socket.async_wait(tcp::socket::wait_read, [state = state_](Error error) {
      if (!error) state->readable = true;
    });
  }

  // Whole at once in all but theory: nothing else is on its way.
  void write_rest() {
    Error error;
    const std::size_t n = state_->socket.write_some(boost::asio::buffer(rest_), error);
    if (error && error != boost::asio::error::would_block) return lose(error.message());
    rest_.erase(0, error ? 0 : n);
    if (rest_.empty()) return;
    state_->socket.async_wait(tcp::socket::wait_write, [state = state_, this](Error wrong) {
      if (!wrong && state->alive && up_) write_rest();
    });
  }

  void lose(const std::string& why) {
    up_ = false;
    error_ = why;
    Error ignored;
    // With a reset: an orderly end would leave the port of an original server that went first in TIME_WAIT, and one
    // that is started again finds it taken and listens on another port without a word.
    state_->socket.set_option(tcp::socket::linger(true, 0), ignored);
    state_->socket.close(ignored);
    rest_.clear();
    wait(state_);
    events_->gone(why);
  }

  std::shared_ptr<State> state_;
  std::string address_;
  std::uint16_t port_;
  Role role_;
  Events* events_ = nullptr;
  bool up_ = false;
  std::string rest_, error_;
};

}  // namespace

std::unique_ptr<Link> make_tcp_link(hal::EventLoop& loop, const Settings& settings, Role role) {
  return std::make_unique<TcpLink>(loop, settings, role);
}

}  // namespace arkmesh::mark
