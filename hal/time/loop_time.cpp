#include "hal/time/loop_time.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>

namespace arkmesh::hal {

namespace asio = boost::asio;

namespace {

constexpr std::chrono::milliseconds serves_at_most{2};

// What is ready, but not for ever: who floods the loop would keep the program from all else. What is left is served the
// next time. Returns whether there was anything.
bool serve_ready(EventLoop& loop) {
  const TimePoint until = TimePoint::clock::now() + serves_at_most;
  bool served = false;
  while (loop.poll_one() > 0) {
    served = true;
    if (TimePoint::clock::now() >= until) break;
  }
  return served;
}

}  // namespace

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
  if (serve_ready(loop_) || then <= now()) return;
  alarm_->timer.expires_at(then);
  alarm_->timer.async_wait([](boost::system::error_code) {});
  loop_.restart();  // as before: it would not wait
  loop_.run_one();
  alarm_->timer.cancel();
  serve_ready(loop_);
}

}  // namespace arkmesh::hal
