#include "tracker/url_trouble.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <utility>

#include "hal/label.hpp"
#include "tracker/lower_case.hpp"

namespace arkmesh::tracker {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds connect_within = 3s, answer_within = 3s;
constexpr std::size_t max_answer_bytes = 8192;

struct Address {
  std::string scheme, host, port, path;
};

Address parts_of(const std::string& url) {
  Address out;
  const std::size_t colon = url.find("://");
  out.scheme = lower_case(url.substr(0, colon));
  const std::string rest = colon == std::string::npos ? "" : url.substr(colon + 3);
  const std::size_t slash = std::min(rest.find_first_of("/?#"), rest.size());
  out.path = slash < rest.size() && rest[slash] == '/' ? rest.substr(slash) : "/" + rest.substr(slash);
  std::string where = rest.substr(0, slash);
  if (const std::size_t at = where.rfind('@'); at != std::string::npos) where = where.substr(at + 1);
  const bool numeric_v6 = where.starts_with('[');
  const std::size_t end = numeric_v6 ? where.find(']') : std::string::npos;
  const std::size_t port = where.find(':', numeric_v6 ? std::min(end, where.size()) : 0);
  out.host = numeric_v6 ? where.substr(1, end == std::string::npos ? end : end - 1) : where.substr(0, port);
  if (port != std::string::npos) out.port = where.substr(port + 1);
  if (out.port.empty())
    out.port = out.scheme == "https" ? "443" : out.scheme == "rtsp" ? "554" : out.scheme == "rtmp" ? "1935" : "80";
  return out;
}

class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int get() const { return fd_; }
  bool wait_for(short events, Clock::time_point until) const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    pollfd waiting{fd_, events, 0};
    return left.count() > 0 && ::poll(&waiting, 1, static_cast<int>(left.count())) == 1;
  }

 private:
  int fd_;
};

// 0, or an errno.
int connect_to(const Socket& socket, const addrinfo& to) {
  ::fcntl(socket.get(), F_SETFL, O_NONBLOCK);
  if (::connect(socket.get(), to.ai_addr, to.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!socket.wait_for(POLLOUT, Clock::now() + connect_within)) return ETIMEDOUT;
  int code = 0;
  socklen_t size = sizeof code;
  return ::getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &code, &size) == 0 ? code : errno;
}

// What is sent back up to the end of the head, as far as it comes in time.
std::string answer_of(const Socket& socket, const Address& to) {
  const std::string request =
      fmt::format("GET {} HTTP/1.0\r\nHost: {}:{}\r\nUser-Agent: arkmesh\r\n\r\n", to.path, to.host, to.port);
  std::string answer;
  if (::send(socket.get(), request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
    return answer;
  const auto end = Clock::now() + answer_within;
  while (answer.size() < max_answer_bytes && answer.find("\r\n\r\n") == std::string::npos &&
         socket.wait_for(POLLIN, end)) {
    std::array<char, 2048> some;
    const ssize_t n = ::recv(socket.get(), some.data(), some.size(), 0);
    if (n <= 0) break;
    answer.append(some.data(), static_cast<std::size_t>(n));
  }
  return answer;
}

constexpr std::size_t longest_answer = 60;  // that is quoted

std::string what_is_wrong_with(const std::string& answer) {
  if (answer.empty()) return "takes the connection and says nothing; is it a camera that speaks HTTP?";
  if (!answer.starts_with("HTTP/")) return "answers, but not in HTTP; is this the port of its pictures?";
  const std::string line = hal::printable(answer.substr(0, answer.find_first_of("\r\n")), longest_answer);
  const std::size_t space = line.find(' ');
  const std::string status = space == std::string::npos ? "" : line.substr(space + 1);
  if (status.starts_with("401") || status.starts_with("403"))
    return fmt::format("answers {}; give user and password as http://USER:PASSWORD@HOST/PATH", status);
  if (status.starts_with("404")) return fmt::format("answers {}; is the path right?", status);
  if (!status.starts_with("2"))
    return fmt::format("answers {}, and no pictures", status.empty() ? "nothing that can be understood" : status);
  const std::string head = lower_case(answer.substr(0, answer.find("\r\n\r\n")));
  const std::size_t type = head.find("\ncontent-type:");
  const std::string is =
      type == std::string::npos
          ? ""
          : hal::printable(head.substr(type + 14, head.find_first_of("\r\n;", type + 14) - type - 14), longest_answer);
  if (is.find("text/html") != std::string::npos)
    return "sends a page, no pictures; give the address of the pictures in it (their streams have addresses of their "
           "own)";
  return fmt::format("sends{}, but no pictures that can be read", is.empty()            ? " something"
                                                                  : is.starts_with(' ') ? is
                                                                                        : " " + is);
}

}  // namespace

std::string url_trouble(const std::string& url) {
  const Address to = parts_of(url);
  const std::string no_pictures = fmt::format("the camera {} gives no pictures", url);
  if (to.scheme == "udp") return no_pictures + ": nothing comes; is it told to send here, and to this port?";
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (const int code = ::getaddrinfo(to.host.c_str(), to.port.c_str(), &hints, &found); code != 0)
    return fmt::format("{}: the host {} is not known ({}); is the name right, and this machine on its network?",
                       no_pictures, to.host, ::gai_strerror(code));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> keeper(found, &::freeaddrinfo);
  int code = EINVAL;
  for (const addrinfo* each = found; each; each = each->ai_next) {
    const Socket socket(::socket(each->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (socket.get() < 0) continue;
    code = connect_to(socket, *each);
    if (code != 0) continue;
    if (to.scheme != "http")
      return fmt::format("{}: {} takes the connection, but sends no video that can be read; is the path right?",
                         no_pictures, to.host);
    return fmt::format("{}: {} port {} {}", no_pictures, to.host, to.port, what_is_wrong_with(answer_of(socket, to)));
  }
  if (code == ECONNREFUSED)
    return fmt::format("{}: nobody listens on port {} of {}; is the camera on, and is this its port?", no_pictures,
                       to.port, to.host);
  if (code == ETIMEDOUT)
    return fmt::format("{}: {} does not answer; is it on, and on this network?", no_pictures, to.host);
  return fmt::format("{}: {} cannot be reached: {}", no_pictures, to.host, std::strerror(code));
}

}  // namespace arkmesh::tracker
