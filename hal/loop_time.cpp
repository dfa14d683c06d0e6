#include "hal/loop_time.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <utility>

namespace arkmesh::hal {

namespace asio = boost::asio;

// Exact to what the kernel's timers are; what Asio itself waits for is whole milliseconds.
struct LoopTime::Alarm {
  explicit Alarm(EventLoop& loop) : timer(loop) {}
  asio::steady_timer timer;
};

LoopTime::LoopTime(EventLoop& loop) : loop_(loop), alarm_(std::make_unique<Alarm>(loop)) {}
LoopTime::~LoopTime() = default;

void LoopTime::wait_until(TimePoint then) {
  do wait_for_anything(then);
  while (now() < then);
}

void LoopTime::wait_for_anything(TimePoint then) {
  loop_.restart();  // with nothing on it, it has stopped
  if (loop_.poll() > 0 || then <= now()) return;
  alarm_->timer.expires_at(then);
  alarm_->timer.async_wait([](boost::system::error_code) {});
  loop_.run_one();
  alarm_->timer.cancel();
  loop_.poll();
}

struct Readable::State : std::enable_shared_from_this<State> {
  State(EventLoop& loop, int descriptor, std::function<void()> what)
      : stream(loop, descriptor), ready(std::move(what)) {}

  void watch() {
    stream.async_wait(asio::posix::stream_descriptor::wait_read,
                      [weak = weak_from_this()](boost::system::error_code error) {
                        const auto self = weak.lock();
                        if (!self || error) return;
                        self->ready();
                        self->watch();
                      });
  }

  asio::posix::stream_descriptor stream;
  std::function<void()> ready;
};

Readable::Readable(EventLoop& loop, int descriptor, std::function<void()> ready)
    : state_(std::make_shared<State>(loop, descriptor, std::move(ready))) {
  state_->watch();
}

Readable::~Readable() {
  state_->stream.release();
}

}  // namespace arkmesh::hal
