#include "emulator/node_port.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <utility>
#include <vector>

#include "hal/listen.hpp"

namespace arkmesh::emulator {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t most_hosts = 8, most_unread = 4 << 20;
constexpr std::chrono::seconds rest_within{1};  // of a message

}  // namespace

struct NodePort::State : std::enable_shared_from_this<State> {
  struct Host {
    tcp::socket socket;
    hal::aseba::MessageReader reader;
    std::array<std::uint8_t, 4096> in{};
    std::vector<std::uint8_t> out, writing;
    std::uint64_t damaged = 0;
    std::chrono::steady_clock::time_point whole_at;  // when no part of a message waited last
  };
  tcp::acceptor acceptor;
  asio::steady_timer again;
  std::function<void(const hal::aseba::Message&)> take;
  std::vector<std::shared_ptr<Host>> hosts;
  hal::Counters counters;

  State(asio::io_context& loop, tcp::acceptor listening, std::function<void(const hal::aseba::Message&)> takes)
      : acceptor(std::move(listening)), again(loop), take(std::move(takes)) {}

  void accept() {
    acceptor.async_accept([this, alive = weak_from_this()](error_code error, tcp::socket socket) {
      const auto self = alive.lock();
      if (!self) return;
      if (error) {  // out of descriptors, say
        again.expires_after(std::chrono::milliseconds(100));
        return again.async_wait([this, alive](error_code) {
          if (alive.lock()) accept();
        });
      }
      if (hosts.size() < most_hosts) {
        hosts.push_back(std::make_shared<Host>(Host{.socket = std::move(socket)}));
        read(hosts.back());
      } else {
        counters.add("nodes.refused.too_many");
      }
      accept();
    });
  }

  void read(const std::shared_ptr<Host>& host) {
    host->socket.async_read_some(
        asio::buffer(host->in), [this, alive = weak_from_this(), host](error_code error, std::size_t bytes) {
          const auto self = alive.lock();
          if (!self) return;
          if (error) return leave(host);
          auto messages = host->reader.read(std::span(host->in).first(bytes));
          const auto now = std::chrono::steady_clock::now();
          if (messages.empty() && host->reader.waits() && now - host->whole_at > rest_within)
            messages = host->reader.give_up();
          if (!messages.empty() || !host->reader.waits()) host->whole_at = now;
          counters.add("nodes.damaged_bytes",
                       host->reader.damaged_bytes() - std::exchange(host->damaged, host->reader.damaged_bytes()));
          for (const hal::aseba::Message& message : messages) take(message);
          read(host);
        });
  }

  void write(const std::shared_ptr<Host>& host) {
    if (!host->writing.empty() || host->out.empty()) return;
    host->writing.swap(host->out);
    asio::async_write(host->socket, asio::buffer(host->writing),
                      [this, alive = weak_from_this(), host](error_code error, std::size_t) {
                        const auto self = alive.lock();
                        if (!self) return;
                        if (error) return leave(host);
                        host->writing.clear();
                        write(host);
                      });
  }

  void leave(const std::shared_ptr<Host>& host) {
    error_code ignored;
    host->socket.close(ignored);
    std::erase(hosts, host);
  }
};

NodePort::NodePort(hal::EventLoop& loop, const std::string& address, std::uint16_t port,
                   std::function<void(const hal::aseba::Message&)> take)
    : state_(std::make_shared<State>(
          loop, hal::listen_on(loop, address, port, "the robots' nodes (emulator.nodes_port)"), std::move(take))) {
  state_->accept();
}

NodePort::~NodePort() = default;

void NodePort::say(std::span<const std::uint8_t> bytes) {
  for (const auto& host : std::vector(state_->hosts)) {
    if (host->out.size() + bytes.size() > most_unread) {
      state_->counters.add("nodes.refused.slow");
      state_->leave(host);
      continue;
    }
    host->out.insert(host->out.end(), bytes.begin(), bytes.end());
    state_->write(host);
  }
}

void NodePort::cut() {
  for (const auto& host : std::vector(state_->hosts)) state_->leave(host);
}

std::uint16_t NodePort::port() const {
  return state_->acceptor.local_endpoint().port();
}

const hal::Counters& NodePort::counters() const {
  return state_->counters;
}

}  // namespace arkmesh::emulator
