#include "gateway/federation/nats_connection.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <mutex>
#include <thread>
#include <utility>

#include "gateway/federation/nats_attempt.hpp"

namespace arkmesh::gateway {

namespace asio = boost::asio;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

using nats::Attempt, nats::Connection, nats::MessagePointer, nats::Polling, nats::read_bytes, nats::Subscription,
    nats::words;

namespace {

constexpr std::chrono::milliseconds echo_period{1000};
constexpr std::chrono::milliseconds patience{3000};  // for a server that forwards nothing
// A server that takes less cannot be used: a frame of a gateway has to fit.
constexpr std::size_t least_payload = 32 << 10;
// What libnats may read before a message is whole: gateways send no packet so long, and
// libnats would hold gigabytes for a server that says so. Nor does it give back what it holds when the connection ends
// in the midst of a message (3.4.1, and later ones), so that a server that always does that is not met often.
constexpr std::size_t most_unfinished_bytes = 1 << 20;

// libnats wakes a thread to destroy a message, so we do that for several at once.
constexpr std::size_t most_done = 64;

std::size_t unread_bytes(int socket) {
  int bytes = 0;
  return ::ioctl(socket, FIONREAD, &bytes) == 0 ? static_cast<std::size_t>(bytes) : 0;
}

}  // namespace

struct NatsConnection::State : std::enable_shared_from_this<State> {
  // Between the loop and a thread that connects.
  struct Door {
    std::mutex guard;
    std::weak_ptr<State> state;      // guarded
    asio::any_io_executor executor;  // guarded; empty once the loop may be gone
    void bring(std::shared_ptr<Attempt> attempt) {
      const std::lock_guard lock(guard);
      if (executor)
        asio::post(executor, [state = state, attempt = std::move(attempt)] {
          if (const auto there = state.lock()) there->adopt(*attempt);
        });
    }
  };

  State(asio::io_context& loop, NatsSettings of, Events told)
      : settings(std::move(of)),
        events(std::move(told)),
        io(loop),
        socket(loop),
        timer(loop),
        door(std::make_shared<Door>()) {}

  void begin() {
    door->state = weak_from_this();
    door->executor = io.get_executor();
    try_next();
    tick();
  }

  void stop() {
    stopped = true;
    events = {};
    {
      const std::lock_guard lock(door->guard);
      door->executor = {};
    }
    timer.cancel();
    drop();
  }

  void try_next() {
    const NatsServer& server = settings.servers.all[tried++ % settings.servers.all.size()];
    there = to_text(server.host);
    trying = true;
    if (why.empty()) why = fmt::format("connecting to the NATS server at {}", there);
    auto attempt = std::make_shared<Attempt>();
    try {
      std::thread([door = door, settings = settings, server, attempt]() mutable {
        connect(settings, server, *attempt);
        door->bring(std::move(attempt));
        attempt.reset();
        nats_ReleaseThreadMemory();
      }).detach();
    } catch (const std::system_error& error) {
      attempt->error = error.what();
      asio::post(io, [self = shared_from_this(), attempt] { self->adopt(*attempt); });
    }
  }

  void adopt(Attempt& attempt) {
    if (stopped) return;
    trying = false;
    if (!attempt.connection) return failed("server.failed.connect", attempt.error);
    polling = std::move(attempt.polling);
    connection = std::move(attempt.connection);
    polling->reading = [this](bool wanted) { poll(wanted); };
    polling->writing = [this](bool wanted) { want_write(wanted); };
    error_code error;
    socket.assign(polling->socket, error);
    payload = static_cast<std::size_t>(std::max<std::int64_t>(0, natsConnection_GetMaxPayload(connection.get())));
    if (payload < least_payload) {
      counters.add("server.refused.payload_limit");
      return failed("", fmt::format("it accepts messages of {} bytes at most; set its max_payload to {} or more",
                                    payload, least_payload));
    }
    for (const std::string& subject : settings.subjects) subscribe(subject);
    if (!settings.own_subject.empty()) subscribe(settings.own_subject);
    if (natsConnection_IsClosed(connection.get())) return failed("server.closed.lost", last_error());
    is_up = true;
    why = fmt::format("connected to the NATS server at {}", there);
    heard = echoed = up_since = Clock::now();
    unfinished_bytes = 0;
    counters.add("server.connected");
    read();
    echo();
    if (const auto tell = events.up) tell();
  }

  void subscribe(const std::string& subject) {
    natsSubscription* made = nullptr;
    if (natsConnection_SubscribeSync(&made, connection.get(), subject.c_str()) == NATS_OK)
      subscriptions.emplace_back(made);
  }

  // libnats stops or goes on reading. It closes the socket itself, once it is told not to be polled.
  void poll(bool wanted) {
    if (!wanted && socket.is_open()) socket.release();
  }

  void read() {
    socket.async_wait(
        asio::posix::stream_descriptor::wait_read, [self = shared_from_this(), of = generation](error_code error) {
          if (error || self->generation != of || !self->connection) return;
          self->unfinished_bytes += std::min(unread_bytes(self->socket.native_handle()), read_bytes);
          natsConnection_ProcessReadEvent(self->connection.get());
          self->collect();
          if (self->generation != of || !self->connection) return;
          if (natsConnection_IsClosed(self->connection.get()))
            return self->failed("server.closed.lost", self->last_error());
          if (self->unfinished_bytes > most_unfinished_bytes)
            return self->failed("server.closed.endless",
                                fmt::format("sent a message of more than {} bytes", most_unfinished_bytes));
          self->read();
        });
  }

  void want_write(bool wanted) {
    wants_write = wanted;
    if (wanted && !in_publish) wait_to_write();
  }

  void wait_to_write() {
    if (waits_to_write || !socket.is_open()) return;
    waits_to_write = true;
    socket.async_wait(asio::posix::stream_descriptor::wait_write,
                      [self = shared_from_this(), of = generation](error_code error) {
                        if (self->generation != of) return;
                        self->waits_to_write = false;
                        if (error || !self->connection) return;
                        self->write();
                        if (self->generation == of && self->connection && !self->wants_write && self->events.writable)
                          self->events.writable();
                      });
  }

  void write() {
    natsConnection_ProcessWriteEvent(connection.get());
    if (natsConnection_IsClosed(connection.get())) return failed_soon();
    if (wants_write) wait_to_write();
  }

  // Who is in the midst of a call of ours is not told at once.
  void failed_soon() {
    asio::post(io, [self = shared_from_this(), of = generation] {
      if (self->generation == of && self->connection) self->failed("server.closed.lost", self->last_error());
    });
  }

  void collect() {
    std::vector<Message> messages;
    bool is_error = false;
    for (const Subscription& each : subscriptions) {
      natsMsg* taken = nullptr;
      while (natsSubscription_NextMsg(&taken, each.get(), 0) == NATS_OK) {
        MessagePointer message(taken);
        unfinished_bytes = 0;
        const std::string_view subject = natsMsg_GetSubject(taken);
        if (subject == settings.own_subject) {
          heard = Clock::now();
        } else {
          const auto* const data = reinterpret_cast<const std::byte*>(natsMsg_GetData(taken));
          messages.push_back({std::string(subject), {data, data + natsMsg_GetDataLength(taken)}});
        }
        done.push_back(std::move(message));
      }
    }
    if (done.size() > most_done) done.clear();
    if (const char* text = nullptr; natsConnection_GetLastError(connection.get(), &text) != NATS_OK && text)
      is_error = std::exchange(said, text) != text;
    if (is_error) counters.add("server.error");
    if (messages.empty()) return;
    if (const auto tell = events.arrived) tell(std::move(messages));
  }

  std::string last_error() const {
    const char* text = nullptr;
    const natsStatus status = natsConnection_GetLastError(connection.get(), &text);
    return status == NATS_OK ? "the connection was closed" : words(status, text);
  }

  void failed(std::string_view counter, const std::string& reason) {
    if (!counter.empty()) counters.add(counter);
    const bool was_up = std::exchange(is_up, false);
    why = fmt::format("NATS server at {}: {}", there, reason);
    drop();
    if (was_up && Clock::now() - up_since >= settings.longest_retry) pause = settings.first_retry;
    next_attempt = Clock::now() + pause;
    pause = std::min(2 * pause, settings.longest_retry);
    if (const auto tell = events.down; tell && was_up) tell();
  }

  void drop() {
    ++generation;
    is_up = waits_to_write = wants_write = false;
    // A close that would wait for the server to take the rest waits for nothing once the socket is shut.
    if (connection && socket.is_open()) {
      ::shutdown(socket.native_handle(), SHUT_RDWR);
      natsConnection_ProcessReadEvent(connection.get());
    }
    if (socket.is_open()) socket.release();
    subscriptions.clear();
    connection.reset();
    polling.reset();
  }

  void echo() {
    if (settings.own_subject.empty()) return;
    natsConnection_Publish(connection.get(), settings.own_subject.c_str(), "", 0);
    echoed = Clock::now();
  }

  void tick() {
    done.clear();
    const auto now = Clock::now();
    if (now - ticked > patience / 2) heard = now;  // it was we who were away
    ticked = now;
    if (is_up && !settings.own_subject.empty() && now - heard > patience) {
      failed("server.closed.silent",
             fmt::format("forwards nothing for {:g} s", std::chrono::duration<double>(patience).count()));
    } else if (is_up && now - echoed >= echo_period) {
      echo();
    } else if (!is_up && !trying && now >= next_attempt) {
      try_next();
    }
    timer.expires_after(std::chrono::milliseconds(50));
    timer.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->stopped) self->tick();
    });
  }

  NatsSettings settings;
  Events events;
  asio::io_context& io;
  std::unique_ptr<Polling> polling;  // libnats points at it
  Connection connection;
  std::vector<Subscription> subscriptions;
  std::vector<MessagePointer> done;       // to be destroyed
  asio::posix::stream_descriptor socket;  // libnats owns the descriptor
  asio::steady_timer timer;
  std::shared_ptr<Door> door;
  std::size_t tried = 0, payload = 0, unfinished_bytes = 0;
  int generation = 0;  // of the connection
  bool is_up = false, trying = false, stopped = false;
  bool wants_write = false, waits_to_write = false, in_publish = false;
  std::string there, why, said;
  std::chrono::milliseconds pause{settings.first_retry};
  Clock::time_point up_since{}, heard{}, echoed{}, ticked = Clock::now(), next_attempt{};
  hal::Counters counters;
};

NatsConnection::NatsConnection(asio::io_context& io, NatsSettings settings, Events events)
    : state_(std::make_shared<State>(io, std::move(settings), std::move(events))) {
  state_->begin();
}

NatsConnection::~NatsConnection() {
  state_->stop();
}

bool NatsConnection::up() const {
  return state_->is_up;
}

const std::string& NatsConnection::why() const {
  return state_->why;
}

std::size_t NatsConnection::max_payload() const {
  return state_->payload;
}

std::size_t NatsConnection::waiting_bytes() const {
  return state_->is_up ? static_cast<std::size_t>(std::max(0, natsConnection_Buffered(state_->connection.get()))) : 0;
}

bool NatsConnection::publish(const std::string& subject, std::span<const std::byte> bytes) {
  State& state = *state_;
  if (!state.is_up || bytes.size() > state.payload) return false;
  state.in_publish = true;
  const natsStatus status =
      natsConnection_Publish(state.connection.get(), subject.c_str(), bytes.data(), static_cast<int>(bytes.size()));
  state.in_publish = false;
  if (status != NATS_OK) return false;
  // What fits into the socket goes now.
  if (!state.waits_to_write) state.write();
  return true;
}

const hal::Counters& NatsConnection::counters() const {
  return state_->counters;
}

}  // namespace arkmesh::gateway
