#include "hal/on_loop.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <utility>

namespace arkmesh::hal {

namespace asio = boost::asio;
using Error = boost::system::error_code;

struct Readable::State : std::enable_shared_from_this<State> {
  State(EventLoop& loop, int descriptor, std::function<void()> what)
      : stream(loop, descriptor), ready(std::move(what)) {}

  void watch() {
    stream.async_wait(asio::posix::stream_descriptor::wait_read, [weak = weak_from_this()](Error error) {
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
