// Nothing is shared: what one thread wants of the other it posts to the other's loop.
#include "emulator/serial_reader.hpp"

#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <utility>

#include "hal/listen.hpp"

namespace arkmesh::emulator {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

// Enough for what a line takes in a second.
constexpr std::size_t max_held_bytes = 4096;

template <class Stream>
struct Source {
  Stream stream;
  std::array<std::uint8_t, 512> buffer{};
  bool reading = false;
};

}  // namespace

struct SerialReader::Thread {
  static constexpr std::chrono::milliseconds accept_again_after{100};  // out of descriptors, say
  static constexpr std::chrono::milliseconds look_who_left_every{100};

  asio::io_context own{1};
  asio::executor_work_guard<asio::io_context::executor_type> work{own.get_executor()};
  asio::io_context& loop;
  std::weak_ptr<std::function<void(Chunk)>> take;
  tcp::acceptor acceptor;
  asio::steady_timer again{own}, look{own};
  Source<asio::posix::stream_descriptor> terminal{asio::posix::stream_descriptor(own)};
  hal::Handle slave;
  Source<tcp::socket> host{tcp::socket(own)};
  bool plugged = false;
  std::size_t held_bytes = 0;

  Thread(asio::io_context& of_owner, const std::string& address, std::uint16_t port)
      : loop(of_owner), acceptor(hal::listen_on(own, address, port, "the overhead controller (emulator.ohc_port)")) {}

  void accept() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
      if (error) {
        again.expires_after(accept_again_after);
        return again.async_wait([this](error_code) { accept(); });
      }
      // behind what the last host's end has to say
      asio::post(own, [this, socket = std::move(socket)]() mutable {
        drop_reset_host();
        // others are sent away at once, as from a port that is in use
        if (plugged && !host.stream.is_open()) {
          host.stream = std::move(socket);
          read(host);
        } else {
          pass_on({}, true);
        }
        accept();
      });
    });
  }

  template <class Stream>
  void read(Source<Stream>& from) {
    if (from.reading || !from.stream.is_open() || held_bytes >= max_held_bytes) return;
    from.reading = true;
    from.stream.async_read_some(asio::buffer(from.buffer), [this, &from](error_code error, std::size_t bytes) {
      from.reading = false;
      held_bytes += bytes;
      if (bytes > 0) pass_on({from.buffer.begin(), from.buffer.begin() + static_cast<std::ptrdiff_t>(bytes)});
      // cut off by set_plugged(): there may be another terminal by now
      if (error && error != asio::error::operation_aborted) close(from.stream);
      if (error == asio::error::connection_reset) pass_on({});
      read(from);
    });
  }

  // As ser2net with `kickolduser` does: a host that has reset its connection is gone with what nobody has read.
  void drop_reset_host() {
    int code = 0;
    socklen_t length = sizeof code;
    if (!host.stream.is_open() ||
        ::getsockopt(host.stream.native_handle(), SOL_SOCKET, SO_ERROR, &code, &length) != 0 || code == 0)
      return;
    close(host.stream);
    pass_on({});
  }

  void pass_on(std::vector<std::uint8_t> bytes, bool refused = false) {
    asio::post(loop, [to = take, chunk = Chunk{std::chrono::steady_clock::now(), std::move(bytes), refused}]() mutable {
      if (const auto living = to.lock()) (*living)(std::move(chunk));
    });
  }

  void look_who_left() {
    if (plugged) free_if_left(terminal.stream.native_handle(), slave);
    look.expires_after(look_who_left_every);
    look.async_wait([this](error_code) { look_who_left(); });
  }

  template <class Stream>
  static void close(Stream& stream) {
    error_code ignored;
    stream.close(ignored);
  }
};

SerialReader::SerialReader(hal::EventLoop& loop, const std::string& address, std::uint16_t port,
                           const std::string& link, std::function<void(Chunk)> take)
    : link_(link),
      take_(std::make_shared<std::function<void(Chunk)>>(std::move(take))),
      reading_(std::make_unique<Thread>(loop, address, port)) {
  port_ = reading_->acceptor.local_endpoint().port();
  reading_->take = take_;
  reading_->accept();
  reading_->look_who_left();
  set_plugged(true);
  thread_ = std::thread([this] { reading_->own.run(); });
}

SerialReader::~SerialReader() {
  reading_->own.stop();
  thread_.join();
}

void SerialReader::done(std::size_t bytes) {
  asio::post(reading_->own, [t = reading_.get(), bytes] {
    t->held_bytes -= bytes;
    t->drop_reset_host();
    t->read(t->terminal);
    t->read(t->host);
  });
}

void SerialReader::set_plugged(bool plugged) {
  if (plugged == terminal_.has_value()) return;
  if (!plugged) {
    terminal_.reset();
    return asio::post(reading_->own, [t = reading_.get()] {
      t->plugged = false;
      t->close(t->terminal.stream);
      t->slave = hal::Handle();
      t->close(t->host.stream);
    });
  }
  terminal_.emplace(link_);
  asio::post(reading_->own,
             [t = reading_.get(), master = terminal_->take_master(), slave = terminal_->take_slave()]() mutable {
               t->plugged = true;
               t->slave = std::move(slave);
               t->terminal.stream.assign(master.release());
               t->read(t->terminal);
             });
}

}  // namespace arkmesh::emulator
