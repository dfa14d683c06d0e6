#include "emulator/control_port.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <utility>

#include "hal/listen.hpp"

namespace arkmesh::emulator {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t max_clients = 8, max_line_bytes = 1024;

// "POST / HTTP/1.1": the line with which browsers begin, whatever a page lets them send behind it.
bool is_http_request(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  const std::size_t version = line.rfind(' ');
  return version != std::string_view::npos && line.substr(version + 1).starts_with("HTTP/");
}

}  // namespace

struct ControlPort::State : std::enable_shared_from_this<State> {
  static constexpr std::chrono::milliseconds accept_again_after{100};  // out of descriptors, say
  struct Client {
    tcp::socket socket;
    std::string in, out;
  };

  tcp::acceptor acceptor;
  asio::steady_timer again;
  std::function<std::string(std::string_view)> answer;
  std::size_t clients = 0;
  hal::Counters counters;

  State(asio::io_context& loop, tcp::acceptor listening, std::function<std::string(std::string_view)> answers)
      : acceptor(std::move(listening)), again(loop), answer(std::move(answers)) {}

  void accept() {
    acceptor.async_accept([this, alive = weak_from_this()](error_code error, tcp::socket socket) {
      const auto self = alive.lock();
      if (!self) return;
      if (error) {
        again.expires_after(accept_again_after);
        return again.async_wait([this, alive](error_code) {
          if (alive.lock()) accept();
        });
      }
      if (clients < max_clients) {
        ++clients;
        read(std::make_shared<Client>(Client{std::move(socket), {}, {}}));
      } else {
        counters.add("control.refused.too_many");
      }
      accept();
    });
  }

  // The client lives as long as one of its operations is pending.
  void read(const std::shared_ptr<Client>& client) {
    asio::async_read_until(client->socket, asio::dynamic_buffer(client->in, max_line_bytes), '\n',
                           [this, alive = weak_from_this(), client](error_code error, std::size_t bytes) {
                             const auto self = alive.lock();
                             if (!self) return;
                             if (error) return static_cast<void>(--clients);
                             const auto line = std::string_view(client->in).substr(0, bytes - 1);
                             if (is_http_request(line)) return refuse(client);
                             client->out = answer(line) + "\n";
                             client->in.erase(0, bytes);
                             write(client);
                           });
  }

  // Nothing that it sent behind this line is read.
  void refuse(const std::shared_ptr<Client>& client) {
    counters.add("control.refused.http");
    client->out =
        "error: this port accepts no HTTP, so that no web page can command the emulator; send lines of text, as with "
        "nc\n";
    asio::async_write(client->socket, asio::buffer(client->out),
                      [this, alive = weak_from_this(), client](error_code, std::size_t) {
                        if (const auto self = alive.lock()) --clients;
                      });
  }

  void write(const std::shared_ptr<Client>& client) {
    asio::async_write(client->socket, asio::buffer(client->out),
                      [this, alive = weak_from_this(), client](error_code error, std::size_t) {
                        const auto self = alive.lock();
                        if (!self) return;
                        if (error) return static_cast<void>(--clients);
                        read(client);
                      });
  }
};

ControlPort::ControlPort(hal::EventLoop& loop, const std::string& address, std::uint16_t port, const std::string& what,
                         std::function<std::string(std::string_view)> answer)
    : state_(std::make_shared<State>(loop, hal::listen_on(loop, address, port, what), std::move(answer))) {
  state_->accept();
}

ControlPort::~ControlPort() = default;

std::uint16_t ControlPort::port() const {
  return state_->acceptor.local_endpoint().port();
}

const hal::Counters& ControlPort::counters() const {
  return state_->counters;
}

}  // namespace arkmesh::emulator
