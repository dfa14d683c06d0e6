#include "hal/child_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace arkmesh::hal {
namespace {

constexpr int line_descriptor = 3;            // in the child
constexpr std::size_t pipe_holds = 64 << 10;  // what a pipe holds
constexpr std::size_t kept = 64 << 10;        // of what a child says until its end

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> out;
  for (std::string& word : words) out.push_back(word.data());
  out.push_back(nullptr);
  return out;
}

std::vector<std::string> with_ours(std::vector<std::string> variables) {
  const std::size_t given = variables.size();
  for (char** each = environ; *each; ++each) {
    const std::string ours = *each, name = ours.substr(0, ours.find('=') + 1);
    if (std::none_of(variables.begin(), variables.begin() + static_cast<std::ptrdiff_t>(given),
                     [&](const std::string& other) { return other.starts_with(name); }))
      variables.push_back(ours);
  }
  return variables;
}

}  // namespace

ChildProcess::ChildProcess(ChildStart start) : own_group_(start.own_group) {
  std::array<int, 2> ends{}, line_ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no more files can be opened");
  output_ = Handle(ends[0]);
  const Handle its_output(ends[1]);
  if (start.has_line && ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, line_ends.data()) != 0)
    throw std::runtime_error("no more files can be opened");
  line_ = Handle(line_ends[0]);
  const Handle its_line(line_ends[1]);
  for (const int each : {output(), line()}) ::fcntl(each, F_SETFL, O_NONBLOCK);

  std::vector<std::string> variables = with_ours(std::move(start.environment));
  const std::vector<char*> words = pointers(start.command), all_variables = pointers(variables);
  if (start.function) std::fflush(nullptr);  // else both would print what waits
  const pid_t parent = ::getpid();
  id_ = ::fork();
  if (id_ < 0) throw std::runtime_error(fmt::format("no more processes can be started: {}", std::strerror(errno)));
  if (id_ > 0) {
    if (own_group_) ::setpgid(id_, id_);  // as it does itself, whoever comes first
    return;
  }
  if (own_group_) ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, start.last_signal);
  if (::getppid() != parent) ::_exit(1);  // it was gone before
  const auto seconds = static_cast<rlim_t>(start.processor_time.count());
  const rlimit processor_time{seconds, seconds + 1};  // then it is killed
  if (start.processor_time.count() > 0) ::setrlimit(RLIMIT_CPU, &processor_time);
  // Neither may be the other's new number.
  const int line_aside = start.has_line ? ::fcntl(its_line.get(), F_DUPFD_CLOEXEC, 10) : -1;
  ::dup2(its_output.get(), STDOUT_FILENO);
  if (start.keeps_errors) ::dup2(its_output.get(), STDERR_FILENO);
  ::dup2(::open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  if (start.has_line) ::dup2(line_aside, line_descriptor);
  if (!start.function) {
    ::execvpe(words[0], words.data(), all_variables.data());
    ::_exit(127);
  }
  ::close(output_.release());
  ::close(ends[1]);
  const int code = start.function();
  std::fflush(nullptr);
  ::_exit(code);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : id_(std::exchange(other.id_, -1)),
      own_group_(other.own_group_),
      output_(std::move(other.output_)),
      line_(std::move(other.line_)) {}

ChildProcess::~ChildProcess() {
  if (id_ < 0) return;
  ::kill(own_group_ ? -id_ : id_, SIGKILL);
  while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

// Leaves it to the destructor to give its number back.
std::optional<ChildProcess::End> ChildProcess::look(bool at_once) const {
  siginfo_t how{};
  int failed = 0;
  do {
    failed = ::waitid(P_PID, static_cast<id_t>(id_), &how, WEXITED | WNOWAIT | (at_once ? WNOHANG : 0));
  } while (failed != 0 && errno == EINTR);
  if (failed == 0 && how.si_pid == 0) return {};
  return how.si_code == CLD_EXITED ? End{how.si_status, 0} : End{128 + how.si_status, how.si_status};
}

std::chrono::nanoseconds ChildProcess::run_delay() const {
  std::int64_t ran = 0, delayed = 0;
  std::ifstream(fmt::format("/proc/{}/schedstat", id_)) >> ran >> delayed;
  return std::chrono::nanoseconds(delayed);
}

bool ChildProcess::read(std::string& text) {
  const std::size_t before = text.size();
  text.resize(before + pipe_holds);
  const ssize_t n = ::read(output(), text.data() + before, pipe_holds);
  text.resize(before + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  if (n == 0) output_ = Handle();
  return static_cast<bool>(output_);
}

Finished run_to_end(ChildStart start, std::optional<std::chrono::milliseconds> limit) {
  using namespace std::chrono_literals;
  const auto begun = std::chrono::steady_clock::now();
  // what it starts is in no way tied to us: should we be killed, that ends by itself
  if (limit && start.processor_time == 0s) start.processor_time = std::chrono::ceil<std::chrono::seconds>(*limit) + 1s;
  ChildProcess child(std::move(start));
  Finished out;
  for (bool more = true; more;) {
    auto left = std::chrono::milliseconds(1min);
    if (limit) left = std::chrono::ceil<std::chrono::milliseconds>(begun + *limit - std::chrono::steady_clock::now());
    out.too_long = left <= 0ms;
    if (out.too_long) return out;
    pollfd said{child.output(), POLLIN, 0};
    ::poll(&said, 1, static_cast<int>(std::min(left, std::chrono::milliseconds(1min)).count()));
    more = child.read(out.output);
    if (out.output.size() > kept) out.output.resize(kept);
  }
  const ChildProcess::End end = child.wait();
  if (end.signal == 0) out.status = end.code;
  out.too_long = end.signal == SIGXCPU;
  return out;
}

}  // namespace arkmesh::hal
