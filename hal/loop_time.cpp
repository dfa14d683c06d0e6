#include "hal/loop_time.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

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
  loop_.restart();  // as before: it would not wait
  loop_.run_one();
  alarm_->timer.cancel();
  loop_.poll();
}

}  // namespace arkmesh::hal
