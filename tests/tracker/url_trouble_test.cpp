// What people are told of a camera's URL that gives no pictures.
#include "tracker/url_trouble.hpp"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>

using arkmesh::tracker::url_trouble;

namespace {

// Takes one connection, says something, and ends it when the other side has gone.
class Speaker {
 public:
  explicit Speaker(const std::string& says) : listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    REQUIRE(::bind(listener_, reinterpret_cast<sockaddr*>(&here), sizeof here) == 0);
    REQUIRE(::listen(listener_, 1) == 0);
    REQUIRE(::getsockname(listener_, reinterpret_cast<sockaddr*>(&here), &size) == 0);
    port_ = ntohs(here.sin_port);
    thread_ = std::thread([this, says] {
      const int client = ::accept(listener_, nullptr, nullptr);
      if (client < 0) return;
      ::send(client, says.data(), says.size(), MSG_NOSIGNAL);
      std::array<char, 512> asked;
      while (::recv(client, asked.data(), asked.size(), 0) > 0) {
      }
      ::close(client);
    });
  }
  ~Speaker() {
    ::shutdown(listener_, SHUT_RDWR);  // wakes an accept that nobody came to
    thread_.join();
    ::close(listener_);
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/table"; }

 private:
  int listener_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

bool tells(const std::string& says, const std::string& part) {
  const Speaker speaker(says);
  const std::string trouble = url_trouble(speaker.url());
  CAPTURE(trouble);
  CHECK(trouble.find(speaker.url()) != std::string::npos);
  CHECK(trouble.find('\n') == std::string::npos);
  return trouble.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("the trouble with a camera's URL is told from what answers there") {
  // Proves one sentence for each: wrong path, a password, a page, another protocol, bytes of all kinds, something that
  // is not said.
  CHECK(tells("HTTP/1.1 404 Not Found\r\n\r\n", "answers 404 Not Found; is the path right?"));
  CHECK(tells("HTTP/1.1 401 Unauthorized\r\n\r\n", "USER:PASSWORD@HOST"));
  CHECK(tells("HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\n\r\n<html>", "sends a page, no pictures"));
  CHECK(tells("HTTP/1.1 200 OK\r\nContent-Type: video/x-none\r\n\r\n",
              "sends video/x-none, but no pictures that can be read"));
  CHECK(tells("HTTP/1.1 \x1b[2J\r\n\r\n", "and no pictures"));
  CHECK(tells("SSH-2.0-OpenSSH_9.2\r\n\r\n", "not in HTTP"));
  CHECK(tells(std::string(20'000, '\xff'), "not in HTTP"));
  CHECK(tells("", "says nothing"));
}

TEST_CASE("a camera's URL at which nothing listens says which port") {
  // Proves the commonest mistakes: the port, and a host that is none.
  CHECK(url_trouble("http://127.0.0.1:1/table").find("nobody listens on port 1 of 127.0.0.1") != std::string::npos);
  CHECK(url_trouble("rtsp://user:word@127.0.0.1:1/").find("nobody listens on port 1 of 127.0.0.1") !=
        std::string::npos);
  CHECK(url_trouble("http://[::1]:1/").find("port 1 of ::1") != std::string::npos);
  CHECK(url_trouble("http://").find("http://") != std::string::npos);
  CHECK(url_trouble("http://127.0.0.1:word/").find("is not known") != std::string::npos);
}
