// The link over real sockets on loopback: who listens, who tries again, what comes in pieces, and who closes.
#include "mark/tcp_link.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "hal/time/loop_time.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

// What the link tells.
struct NotedEvents final : mark::Link::Events {
  void came() override { ++comings; }
  void heard(std::string_view bytes) override { text += bytes; }
  void gone(const std::string& why) override { losses.push_back(why); }
  int comings = 0;
  std::string text;
  std::vector<std::string> losses;
};

// A plain socket, as the original has it.
class PlainSocket {
 public:
  PlainSocket() : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {}
  explicit PlainSocket(int descriptor) : descriptor_(descriptor) {}
  ~PlainSocket() { close(); }
  PlainSocket(const PlainSocket&) = delete;
  PlainSocket& operator=(const PlainSocket&) = delete;

  void close() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }
  bool connect(int port) {
    const sockaddr_in to = at(port);
    if (::connect(descriptor_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return true;
    close();
    descriptor_ = ::socket(AF_INET, SOCK_STREAM, 0);
    return false;
  }
  // Listens on a port; 0: any. Which one. As the original, not where a former connection is still in TIME_WAIT.
  int listen(int port = 0) {
    sockaddr_in here = at(port);
    REQUIRE(::bind(descriptor_, reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0);
    REQUIRE(::listen(descriptor_, 1) == 0);
    socklen_t size = sizeof here;
    ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&here), &size);
    return ntohs(here.sin_port);
  }
  // The next connection; -1: none yet.
  int accept() {
    ::fcntl(descriptor_, F_SETFL, O_NONBLOCK);
    return ::accept(descriptor_, nullptr, nullptr);
  }
  void send(std::string_view bytes) {
    const int yes = 1;
    ::setsockopt(descriptor_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    CHECK(::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size()));
  }
  // What is there now; "closed" when the other end has closed.
  std::string receive() {
    char bytes[4096];
    const ssize_t n = ::recv(descriptor_, bytes, sizeof bytes, MSG_DONTWAIT);
    return n == 0 ? "closed" : n < 0 ? "" : std::string(bytes, static_cast<std::size_t>(n));
  }

 private:
  static sockaddr_in at(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }
  int descriptor_;
};

int free_port() {
  PlainSocket socket;
  return socket.listen();
}

// A link and the loop that serves it.
class LinkBench {
 public:
  LinkBench(mark::Role role, int port, bool open = true) {
    mark::Settings settings;
    settings.port = static_cast<std::uint16_t>(port);
    link = mark::make_tcp_link(loop_, settings, role);
    link->start(events);
    if (open) link->open();
  }
  template <class Condition>
  bool until(Condition condition) {
    return tests::eventually(300s, [&] {
      time_.wait_for_anything(time_.now() + 2ms);
      link->serve();
      return condition();
    });
  }
  void for_a_while() {
    for (int i = 0; i < 50; ++i) time_.wait_for_anything(time_.now() + 2ms), link->serve();
  }

 private:
  hal::EventLoop loop_;
  hal::LoopTime time_{loop_};

 public:
  NotedEvents events;
  std::unique_ptr<mark::Link> link;
};

}  // namespace

TEST_CASE("nobody can connect to a server, and no client connects, before the link is open") {
  // An original counts its time from the moment when it is connected; the kernel connects it to whoever listens.
  const int port = free_port();
  LinkBench server(mark::Role::server, port, false);
  PlainSocket original;
  CHECK_FALSE(original.connect(port));
  server.link->open();
  CHECK(original.connect(port));
  CHECK(server.until([&] { return server.events.comings == 1; }));

  PlainSocket other;
  const int there = other.listen();
  LinkBench client(mark::Role::client, there, false);
  client.for_a_while();
  CHECK(other.accept() < 0);
  client.link->open();
  CHECK(client.until([&] { return client.events.comings == 1; }));
}

TEST_CASE("the server takes one client, and another one after it has gone") {
  // While one is there the port is closed, so that a second one tries in vain and is not hurt by being closed on.
  const int port = free_port();
  LinkBench bench(mark::Role::server, port);
  PlainSocket first, second;
  CHECK(bench.until([&] { return first.connect(port); }));
  REQUIRE(bench.until([&] { return bench.link->up(); }));
  CHECK_FALSE(second.connect(port));
  first.send("Missing par");
  bench.for_a_while();
  first.send(std::string("ameters\0T001", 12));
  REQUIRE(bench.until([&] { return bench.events.text.size() == 23; }));
  CHECK(bench.events.text == std::string("Missing parameters\0T001", 23));
  // One write is one segment.
  REQUIRE(bench.link->settled());
  bench.link->send(std::string("Ibc0101\0", 8));
  std::string got;
  REQUIRE(bench.until([&] { return !(got = first.receive()).empty(); }));
  CHECK(got == std::string("Ibc0101\0", 8));
  CHECK(bench.until([&] { return bench.link->settled(); }));
  first.close();
  REQUIRE(bench.until([&] { return !bench.link->up(); }));
  CHECK(bench.events.losses == std::vector<std::string>{"it closed its connection"});
  REQUIRE(bench.until([&] { return second.connect(port); }));
  REQUIRE(bench.until([&] { return bench.link->up(); }));
  CHECK(bench.events.comings == 2);
  bench.for_a_while();
  CHECK(second.receive().empty());  // neither said anything to it nor closed it
}

TEST_CASE("the client tries until the server listens, and again after it was started anew") {
  // The original server listens while it starts, takes one and closes its port. When it has ended, the port is free at
  // once: started anew it would listen on another one without a word.
  const int port = free_port();
  LinkBench bench(mark::Role::client, port);
  bench.for_a_while();
  CHECK_FALSE(bench.link->up());
  for (int round = 0; round < 2; ++round) {
    PlainSocket listening;
    listening.listen(port);
    int accepted = -1;
    REQUIRE(bench.until([&] { return (accepted = listening.accept()) >= 0; }));
    PlainSocket server(accepted);
    listening.close();
    REQUIRE(bench.until([&] { return bench.link->up(); }));
    server.send("I");
    CHECK(bench.until([&] { return bench.events.text.size() == static_cast<std::size_t>(round) + 1; }));
    server.close();
    REQUIRE(bench.until([&] { return !bench.link->up(); }));
    bench.for_a_while();
    CHECK_FALSE(bench.link->error().empty());
  }
  CHECK(bench.events.comings == 2);
  CHECK(bench.events.losses.size() == 2);
}

TEST_CASE("a connection on which nothing is said is probed") {
  // A machine that lost its power tells nobody. The probe is answered when it is back, and its new original is let in.
  const int port = free_port();
  LinkBench bench(mark::Role::server, port);
  PlainSocket client;
  CHECK(bench.until([&] { return client.connect(port); }));
  REQUIRE(bench.until([&] { return bench.link->up(); }));
  // Columns of /proc/net/tcp: number, local address, remote address, state (01: connected), queues, timer (02: probe).
  const auto is_probed = [&] {
    std::ifstream table("/proc/net/tcp");
    std::string number, local, remote, state, queues, timer;
    for (std::string line; std::getline(table, line);) {
      std::istringstream(line) >> number >> local >> remote >> state >> queues >> timer;
      if (local == fmt::format("0100007F:{:04X}", port) && state == "01") return timer.starts_with("02");
    }
    return false;
  };
  CHECK(is_probed());
}

TEST_CASE("a port that is taken is one sentence") {
  PlainSocket other;
  const int port = other.listen();
  try {
    LinkBench bench(mark::Role::server, port);
    FAIL("it listens on a port that another program has");
  } catch (const std::runtime_error& error) {
    CHECK(std::string(error.what()).find(std::to_string(port)) != std::string::npos);
    CHECK(std::string(error.what()).find("is in use by another program") != std::string::npos);
  }
}

TEST_CASE("a flood keeps nobody from his work") {
  // A megabyte at once is handed over in parts of 16 KiB, one for each look.
  const int port = free_port();
  LinkBench bench(mark::Role::server, port);
  PlainSocket client;
  REQUIRE(bench.until([&] { return client.connect(port); }));
  REQUIRE(bench.until([&] { return bench.link->up(); }));
  std::size_t before = 0, most = 0, sent = 0;
  const std::string block(4096, 'x');
  while (sent < (1 << 20)) {
    for (int i = 0; i < 16; ++i) client.send(block), sent += block.size();
    REQUIRE(bench.until([&] {
      most = std::max(most, bench.events.text.size() - before);
      before = bench.events.text.size();
      return before == sent;
    }));
  }
  CHECK(most <= (16 << 10) + 4096);
}
