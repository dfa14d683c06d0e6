#include "scenarios/python/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace arkmesh::scenarios::python {
namespace {

constexpr std::size_t head_bytes = 5;
constexpr int child_descriptor = 3;

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> out;
  for (std::string& word : words) out.push_back(word.data());
  out.push_back(nullptr);
  return out;
}

}  // namespace

Child::Child(std::vector<std::string> command, const std::vector<std::string>& environment) {
  std::array<int, 2> line{}, prints{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, line.data()) != 0)
    throw std::runtime_error("no more files can be opened");
  socket_ = hal::Handle(line[0]);
  hal::Handle its_line(line[1]);
  if (::pipe2(prints.data(), O_CLOEXEC) != 0) throw std::runtime_error("no more files can be opened");
  prints_ = hal::Handle(prints[0]);
  hal::Handle its_prints(prints[1]);
  for (const int each : {socket_.get(), prints_.get()}) ::fcntl(each, F_SETFL, O_NONBLOCK);

  std::vector<std::string> variables = environment;
  for (char** each = environ; *each; ++each) {
    const std::string_view name = std::string_view(*each).substr(0, std::string_view(*each).find('='));
    bool given = false;
    for (const std::string& other : environment) given = given || other.substr(0, other.find('=')) == name;
    if (!given) variables.emplace_back(*each);
  }
  std::vector<char*> arguments = pointers(command), all_variables = pointers(variables);
  const pid_t parent = ::getpid();
  id_ = ::fork();
  if (id_ < 0) throw std::runtime_error(fmt::format("no more processes can be started: {}", std::strerror(errno)));
  if (id_ == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);  // it was gone before
    // Neither end may be the other's new number.
    const int line_aside = ::fcntl(its_line.get(), F_DUPFD_CLOEXEC, 10);
    ::dup2(its_prints.get(), STDOUT_FILENO);
    ::dup2(its_prints.get(), STDERR_FILENO);
    const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(line_aside, child_descriptor);
    ::execvpe(arguments[0], arguments.data(), all_variables.data());
    ::_exit(127);
  }
  ::setpgid(id_, id_);
}

Child::~Child() {
  ::kill(-id_, SIGKILL);
  ::waitpid(id_, nullptr, 0);
}

void Child::send(char kind, std::string_view content) {
  const auto size = static_cast<std::uint32_t>(content.size());
  out_.append(reinterpret_cast<const char*>(&size), sizeof size);
  out_ += kind;
  out_ += content;
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
  std::array<pollfd, 2> both{pollfd{socket_.get(), static_cast<short>(POLLIN | (out_.empty() ? 0 : POLLOUT)), 0},
                             pollfd{prints_.get(), POLLIN, 0}};
  const int ready = ::poll(both.data(), both.size(), static_cast<int>(wait.count()));
  if (ready < 0) return false;
  std::array<char, 1 << 16> some;
  if ((both[1].revents & (POLLIN | POLLHUP)) != 0) {
    const ssize_t n = ::read(prints_.get(), some.data(), some.size());
    const std::size_t got = n > 0 ? static_cast<std::size_t>(n) : 0;
    const std::size_t kept = std::min<std::size_t>(got, max_output - kept_);
    printed_.append(some.data(), kept);
    kept_ += kept;
    dropped_ += got - kept;
    if (n == 0) prints_ = hal::Handle();  // it has closed both; poll passes over it from now on
  }
  if ((both[0].revents & POLLOUT) != 0) {
    const ssize_t n = ::send(socket_.get(), out_.data(), out_.size(), MSG_NOSIGNAL);
    if (n > 0) out_.erase(0, static_cast<std::size_t>(n));
  }
  if ((both[0].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
    const ssize_t n = ::recv(socket_.get(), some.data(), some.size(), 0);
    if (n > 0) in_.append(some.data(), static_cast<std::size_t>(n));
    ended_ = n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR);
  }
  return true;
}

std::optional<Message> Child::next() {
  if (in_.size() < head_bytes) return std::nullopt;
  std::uint32_t size = 0;
  std::memcpy(&size, in_.data(), sizeof size);
  if (size > max_message) throw std::runtime_error(fmt::format("said {} bytes at once; {} fit", size, max_message));
  if (in_.size() < head_bytes + size) return std::nullopt;
  Message message{in_[4], in_.substr(head_bytes, size)};
  in_.erase(0, head_bytes + size);
  return message;
}

void Child::gone() {
  for (int i = 0; i < 20 && pump(std::chrono::milliseconds(0)); ++i) {
  }
  siginfo_t how{};
  // It has closed its end, so it ends, or is made to.
  for (int i = 0; i < 100 && how.si_pid == 0; ++i) {
    ::waitid(P_PID, static_cast<id_t>(id_), &how, WEXITED | WNOWAIT | WNOHANG);
    if (how.si_pid == 0) ::poll(nullptr, 0, 10);
  }
  if (how.si_pid == 0) throw std::runtime_error("closed its line to the lab");
  if (how.si_code != CLD_EXITED) throw std::runtime_error(fmt::format("was killed by signal {}", how.si_status));
  if (how.si_status == 127)
    throw std::runtime_error("cannot be run: there is no such Python; name one in the environment, as ARKMESH_PYTHON");
  throw std::runtime_error(fmt::format("ended by itself, with exit code {}", how.si_status));
}

std::string Child::take_output() {
  return std::exchange(printed_, {});
}

void Child::ask_where() {
  ::kill(id_, SIGUSR1);
}

}  // namespace arkmesh::scenarios::python
