#include "scenarios/python/child.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace arkmesh::scenarios::python {
namespace {

constexpr std::size_t head_bytes = 5;
}  // namespace

Child::Child(std::vector<std::string> command, std::vector<std::string> environment)
    : process_({.command = std::move(command), .environment = std::move(environment), .has_line = true}),
      processor_(process_.id()) {}

void Child::send(char kind, std::string_view content) {
  const auto size = static_cast<std::uint32_t>(content.size());
  out_.append(reinterpret_cast<const char*>(&size), sizeof size);
  out_ += kind;
  out_ += content;
  give();
}

// As much as there is room for.
void Child::give() {
  const ssize_t n = ::send(process_.line(), out_.data(), out_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (n > 0) out_.erase(0, static_cast<std::size_t>(n));
}

std::optional<Message> Child::receive(std::chrono::milliseconds wait) {
  using Clock = std::chrono::steady_clock;
  for (const auto until = Clock::now() + wait;;) {
    if (auto message = next()) return message;
    if (ended_) gone();
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    if (!pump(std::max(left, std::chrono::milliseconds(0)))) return next();
    if (left.count() <= 0) return next();
  }
}

// False: a signal came instead.
bool Child::pump(std::chrono::milliseconds wait) {
  std::array<pollfd, 2> both{pollfd{process_.line(), static_cast<short>(POLLIN | (out_.empty() ? 0 : POLLOUT)), 0},
                             pollfd{process_.output(), POLLIN, 0}};
  if (::poll(both.data(), both.size(), static_cast<int>(wait.count())) < 0) return false;
  if (both[1].revents != 0) {
    std::string said;
    process_.read(said);
    const std::size_t fits = std::min(said.size(), max_output - kept_);
    printed_.append(said, 0, fits);
    kept_ += fits;
    dropped_ += said.size() - fits;
  }
  if ((both[0].revents & POLLOUT) != 0) give();
  if ((both[0].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
    std::array<char, 1 << 16> some;
    const ssize_t n = ::recv(process_.line(), some.data(), some.size(), 0);
    if (n > 0) in_.append(some.data(), static_cast<std::size_t>(n));
    ended_ = n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR);
  }
  return true;
}

std::optional<Message> Child::next() {
  if (in_.size() < head_bytes) return std::nullopt;
  std::uint32_t size = 0;
  std::memcpy(&size, in_.data(), sizeof size);
  if (size > max_message)
    throw std::runtime_error(fmt::format("sent {} bytes at once; the limit is {}", size, max_message));
  if (in_.size() < head_bytes + size) return std::nullopt;
  Message message{in_[4], in_.substr(head_bytes, size)};
  in_.erase(0, head_bytes + size);
  return message;
}

void Child::gone() {
  // It has closed its end, so it ends, or is made to. What it says until then is heard.
  std::optional<hal::ChildProcess::End> end;
  for (int i = 0; i < 100 && !(end = process_.end()); ++i) {
    pump(std::chrono::milliseconds(0));
    ::poll(nullptr, 0, 10);
  }
  for (int i = 0; i < 20 && pump(std::chrono::milliseconds(0)); ++i) {
  }
  if (!end) throw std::runtime_error("closed its line to the lab");
  if (end->signal != 0) throw std::runtime_error(fmt::format("was killed by signal {}", end->signal));
  if (end->code == 127)
    throw std::runtime_error(
        "cannot be run: there is no such Python; name one in the environment variable ARKMESH_PYTHON");
  throw std::runtime_error(fmt::format("ended by itself, with exit code {}", end->code));
}

std::string Child::take_output() {
  return std::exchange(printed_, {});
}

void Child::begin_to_wait() {
  asked_ = std::chrono::steady_clock::now();
  if (asked_ - delay_read_ < std::chrono::seconds(1)) return;  // reading takes longer than most answers
  delay_read_ = asked_;
  delayed_ = process_.run_delay();
}

std::chrono::nanoseconds Child::waited() const {
  return std::chrono::steady_clock::now() - asked_ - (process_.run_delay() - delayed_);
}

bool Child::has_waited(std::chrono::nanoseconds time) const {
  // the clock alone tells mostly, and costs less
  return std::chrono::steady_clock::now() - asked_ >= time && waited() >= time;
}

void Child::ask_where() {
  process_.signal(SIGUSR1);
}

}  // namespace arkmesh::scenarios::python
