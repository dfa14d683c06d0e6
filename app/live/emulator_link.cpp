#include "app/live/emulator_link.hpp"

#include <fmt/format.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <sstream>
#include <utility>

namespace arkmesh::app {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr std::chrono::seconds answer_within{2};
constexpr std::size_t longest_answer = 16 << 10, max_waiting = 4;  // the emulator takes eight clients

}  // namespace

// A connection for each: questions are few, and nothing is to be kept up. Lives as long as something is pending.
struct EmulatorLink::Question : std::enable_shared_from_this<Question> {
  Question(hal::EventLoop& loop, std::string_view line, Heard who)
      : socket(loop), late(loop), out(std::string(line) + "\n"), heard(std::move(who)) {}

  void start(const asio::ip::tcp::endpoint& to) {
    std::ostringstream words;
    words << to;
    where = words.str();
    const auto self = shared_from_this();
    late.expires_after(answer_within);
    late.async_wait([self](error_code error) {
      if (!error) self->fail(fmt::format("no answer within {} s", answer_within.count()));
    });
    socket.async_connect(to, [self](error_code error) { error ? self->fail(error.message()) : self->write(); });
  }
  void write() {
    asio::async_write(socket, asio::buffer(out), [self = shared_from_this()](error_code error, std::size_t) {
      error ? self->fail(error.message()) : self->read();
    });
  }
  void read() {
    asio::async_read_until(socket, asio::dynamic_buffer(in, longest_answer), '\n',
                           [self = shared_from_this()](error_code error, std::size_t bytes) {
                             error ? self->fail(error.message()) : self->end(self->in.substr(0, bytes - 1));
                           });
  }
  void fail(const std::string& why) {
    end(fmt::format("error: the emulator at {} (view.emulator) does not answer: {}", where, why));
  }
  void end(const std::string& said) {
    error_code ignored;
    socket.close(ignored);
    late.cancel();
    if (heard) std::exchange(heard, nullptr)(said);
  }

  asio::ip::tcp::socket socket;
  asio::steady_timer late;
  std::string out, in, where;
  Heard heard;  // null: it has heard
};

EmulatorLink::~EmulatorLink() {
  for (const auto& weak : waiting_)
    if (const auto question = weak.lock()) {
      question->heard = nullptr;
      question->end({});
    }
}

void EmulatorLink::ask(std::string_view line, Heard heard) {
  std::erase_if(waiting_, [](const auto& one) { return one.expired(); });
  if (waiting_.size() >= max_waiting)
    return heard("error: the emulator has not answered the previous command; try again");
  const auto question = std::make_shared<Question>(loop_, line, std::move(heard));
  waiting_.push_back(question);
  question->start(to_);
}

}  // namespace arkmesh::app
