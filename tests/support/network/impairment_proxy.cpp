// One pump per direction of each connection: reads, damages, queues with the time when it may go on, writes in slices.
#include "tests/support/network/impairment_proxy.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "hal/random.hpp"

namespace arkmesh::tests {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t read_bytes = 16 << 10;
// What may be under way in one direction; then nothing is read, and the sender feels it.
constexpr std::size_t max_under_way = 1 << 20, max_under_way_when_rated = 16 << 10;

struct Shared {
  asio::io_context io{1};
  Impairment impairment;
  std::mutex guard;  // guards counts, which other threads read
  ImpairmentProxy::Counts counts;
  hal::RandomStream chance{1, "impairment"};

  // In the loop's thread, which alone writes counts.
  bool stalls() const {
    return impairment.stall || (impairment.hold_after > 0 && counts.bytes_to_target >= impairment.hold_after);
  }
  void count(std::uint64_t ImpairmentProxy::Counts::*what, std::uint64_t n = 1) {
    const std::lock_guard lock(guard);
    counts.*what += n;
  }
};

// One direction.
struct Pump {
  struct Chunk {
    Clock::time_point due;
    std::vector<unsigned char> bytes;
    std::size_t written = 0;
  };
  Pump(Shared& all, tcp::socket& in, tcp::socket& out, bool towards_target)
      : shared(all), from(in), to(out), to_target(towards_target), timer(all.io) {}

  Shared& shared;
  tcp::socket& from;
  tcp::socket& to;
  const bool to_target;
  asio::steady_timer timer;
  std::vector<unsigned char> buffer = std::vector<unsigned char>(read_bytes);
  std::deque<Chunk> under_way;
  std::size_t bytes_under_way = 0, since_corrupted = 0;
  Clock::time_point free_at{};  // when the rate allows the next write
  bool reading = false, writing = false;
  bool ended = false;  // nothing more to read
  bool sink = false;   // `to` is gone, and nobody behind `from` may learn it

  // In a black hole not even the end of a connection is passed on.
  bool swallows() const {
    return sink || (to_target ? shared.impairment.swallow_to_target : shared.impairment.swallow_to_client);
  }
};

// A client's connection and ours to the target.
struct Connection : std::enable_shared_from_this<Connection> {
  Connection(Shared& all, tcp::socket accepted)
      : shared(all),
        client(std::move(accepted)),
        target(all.io),
        up(all, client, target, true),
        down(all, target, client, false) {}

  void join(const tcp::endpoint& to) {
    target.async_connect(to, [self = shared_from_this()](error_code error) {
      if (error) {
        self->shared.count(&ImpairmentProxy::Counts::target_refused);
        return self->close();
      }
      self->shared.count(&ImpairmentProxy::Counts::connections);
      error_code ignored;
      self->client.set_option(tcp::no_delay(true), ignored);
      self->target.set_option(tcp::no_delay(true), ignored);
      self->joined = true;
      self->go_on();
    });
  }

  // After the impairment changed, too.
  void go_on() {
    if (closed || !joined) return;
    for (Pump* pump : {&up, &down}) {
      read(*pump);
      write(*pump);
    }
  }

  void read(Pump& pump) {
    const Impairment& now = shared.impairment;
    const std::size_t most = now.bytes_per_s > 0 ? max_under_way_when_rated : max_under_way;
    if (closed || pump.reading || pump.ended || shared.stalls() || pump.bytes_under_way >= most) return;
    pump.reading = true;
    pump.from.async_read_some(asio::buffer(pump.buffer),
                              [self = shared_from_this(), &pump](error_code error, std::size_t bytes) {
                                pump.reading = false;
                                if (self->closed) return;
                                if (error) {
                                  pump.ended = true;  // passed on when all before it has been
                                  return self->write(pump);
                                }
                                self->take(pump, bytes);
                                self->read(pump);
                                self->write(pump);
                              });
  }

  void take(Pump& pump, std::size_t bytes) {
    const Impairment& now = shared.impairment;
    if (pump.swallows()) return shared.count(&ImpairmentProxy::Counts::swallowed, bytes);
    Pump::Chunk chunk;
    chunk.bytes.assign(pump.buffer.begin(), pump.buffer.begin() + static_cast<std::ptrdiff_t>(bytes));
    if (now.corrupt_every > 0)
      for (unsigned char& byte : chunk.bytes)
        if (++pump.since_corrupted >= now.corrupt_every) {
          pump.since_corrupted = 0;
          byte ^= static_cast<unsigned char>(1u << shared.chance.below(8));
          shared.count(&ImpairmentProxy::Counts::corrupted);
        }
    chunk.due = Clock::now() + now.delay;
    if (now.jitter.count() > 0)
      chunk.due += std::chrono::microseconds(shared.chance.below(static_cast<std::uint64_t>(now.jitter.count()) + 1));
    if (!pump.under_way.empty()) chunk.due = std::max(chunk.due, pump.under_way.back().due);
    pump.bytes_under_way += bytes;
    pump.under_way.push_back(std::move(chunk));
  }

  void write(Pump& pump) {
    if (closed || pump.writing || shared.stalls()) return;
    if (pump.under_way.empty()) {
      if (pump.ended && !pump.swallows()) close();
      return;
    }
    Pump::Chunk& chunk = pump.under_way.front();
    pump.writing = true;
    if (const auto due = std::max(chunk.due, pump.free_at); due > Clock::now()) {
      pump.timer.expires_at(due);
      pump.timer.async_wait([self = shared_from_this(), &pump](error_code) {
        pump.writing = false;
        self->write(pump);
      });
      return;
    }
    std::size_t bytes = chunk.bytes.size() - chunk.written;
    if (const std::size_t slice = shared.impairment.slice_bytes; slice > 0) bytes = std::min(bytes, slice);
    if (const std::size_t rate = shared.impairment.bytes_per_s; rate > 0)
      bytes = std::min(bytes, std::max<std::size_t>(1, rate / 100));
    pump.to.async_write_some(asio::buffer(chunk.bytes.data() + chunk.written, bytes),
                             [self = shared_from_this(), &pump](error_code error, std::size_t written) {
                               pump.writing = false;
                               if (self->closed) return;
                               if (error) return self->on_write_failed(pump);
                               self->on_written(pump, written);
                             });
  }

  void on_written(Pump& pump, std::size_t bytes) {
    Pump::Chunk& chunk = pump.under_way.front();
    {
      const std::lock_guard lock(shared.guard);
      (pump.to_target ? shared.counts.bytes_to_target : shared.counts.bytes_to_client) += bytes;
      ++shared.counts.writes;
    }
    if (const std::size_t rate = shared.impairment.bytes_per_s; rate > 0)
      pump.free_at = std::max(pump.free_at, Clock::now() - std::chrono::milliseconds(10)) +
                     std::chrono::nanoseconds(1'000'000'000ull * bytes / rate);
    pump.bytes_under_way -= bytes;
    chunk.written += bytes;
    if (chunk.written == chunk.bytes.size()) pump.under_way.pop_front();
    write(pump);
    read(pump);
  }

  // The news would travel back, in the other direction.
  void on_write_failed(Pump& pump) {
    if (!(pump.to_target ? down : up).swallows()) return close();
    pump.sink = true;
    shared.count(&ImpairmentProxy::Counts::swallowed, pump.bytes_under_way);
    pump.under_way.clear();
    pump.bytes_under_way = 0;
  }

  void close(bool with_reset = false) {
    if (closed) return;
    closed = true;
    error_code ignored;
    for (tcp::socket* socket : {&client, &target}) {
      if (with_reset) socket->set_option(asio::socket_base::linger(true, 0), ignored);
      socket->close(ignored);
    }
    up.timer.cancel();
    down.timer.cancel();
  }

  Shared& shared;
  tcp::socket client, target;
  Pump up, down;
  bool joined = false, closed = false;
};

}  // namespace

struct ImpairmentProxy::State {
  explicit State(std::uint16_t to) : target(asio::ip::address_v4::loopback(), to), acceptor(shared.io) {}

  Shared shared;
  tcp::endpoint target, here;
  tcp::acceptor acceptor;
  std::vector<std::shared_ptr<Connection>> connections;
  std::thread thread;

  void listen(std::uint16_t port) {
    acceptor.open(tcp::v4());
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind({asio::ip::address_v4::loopback(), port});
    acceptor.listen();
    here = acceptor.local_endpoint();
    accept();
  }

  void accept() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
      if (error) return;
      std::erase_if(connections, [](const auto& connection) { return connection->closed; });
      connections.push_back(std::make_shared<Connection>(shared, std::move(socket)));
      connections.back()->join(target);
      accept();
    });
  }

  void reset() {
    for (const auto& connection : connections) {
      if (connection->closed) continue;
      connection->close(true);
      shared.count(&Counts::resets);
    }
    connections.clear();
  }

  // In the loop's thread; returns when it is done.
  void perform(const std::function<void()>& action) {
    if (!thread.joinable()) return action();
    std::promise<void> done;
    asio::post(shared.io, [&] {
      action();
      done.set_value();
    });
    done.get_future().wait();
  }
};

ImpairmentProxy::ImpairmentProxy(std::uint16_t target_port, std::uint16_t port, Mode mode)
    : state_(std::make_unique<State>(target_port)) {
  state_->listen(port);
  if (mode == Mode::thread)
    state_->thread = std::thread([state = state_.get()] {
      const auto work = asio::make_work_guard(state->shared.io);
      state->shared.io.run();
    });
}

ImpairmentProxy::~ImpairmentProxy() {
  state_->shared.io.stop();
  if (state_->thread.joinable()) state_->thread.join();
}

std::uint16_t ImpairmentProxy::port() const {
  return state_->here.port();
}

void ImpairmentProxy::poll() {
  state_->shared.io.restart();
  state_->shared.io.poll();
}

void ImpairmentProxy::set(const Impairment& impairment) {
  state_->perform([&] {
    state_->shared.impairment = impairment;
    for (const auto& connection : state_->connections) connection->go_on();
  });
}

void ImpairmentProxy::reset() {
  state_->perform([&] { state_->reset(); });
}

void ImpairmentProxy::refuse(bool refused) {
  state_->perform([&] {
    error_code ignored;
    if (refused) {
      state_->acceptor.close(ignored);
      state_->reset();
    } else if (!state_->acceptor.is_open()) {
      state_->listen(state_->here.port());
    }
  });
}

ImpairmentProxy::Counts ImpairmentProxy::counts() const {
  const std::lock_guard lock(state_->shared.guard);
  return state_->shared.counts;
}

}  // namespace arkmesh::tests
