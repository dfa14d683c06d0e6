// What reaches an overhead controller after the program that drove it was killed.
#include "hal/platforms/kilobot/pause_guard.hpp"

#include <doctest/doctest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <vector>

#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "hal/platforms/kilobot/packet.hpp"
#include "tests/support/kilobot/listener.hpp"
#include "tests/support/kilobot/packet_ear.hpp"
#include "tests/support/processes/process.hpp"
#include "tests/support/processes/pseudo_terminal.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds guard_deadline = 60s;
const Packet run_packet = forward_packet(Message{.type = type_run}),
             wake_packet = forward_packet(Message{.type = type_wakeup});

// A program that opens the line, opens it again when it is cut, says `run`, and half of it again.
[[noreturn]] void drive(const std::string& port) {
  const std::unique_ptr<ByteStream> line = guarded(make_byte_stream(port));
  const auto open = [&] {
    line->open();
    return line->check() == ByteStream::State::open;
  };
  for (int i = 0; i < 2; ++i) {
    while (!open()) ::usleep(1000);
    line->write(run_packet);
    while (i == 0 && line->check() == ByteStream::State::open) ::usleep(1000);
  }
  line->write(std::span(run_packet).first(70));
  for (;;) ::pause();
}

}  // namespace

TEST_CASE("pause guard: a program that is killed has its robots paused") {
  Listener listener;
  const pid_t program = ::fork();
  if (program == 0) {
    ::setpgid(0, 0);
    drive(listener.port());
  }
  std::size_t bytes = 0;
  const auto listen = [&] { return bytes += listener.read().size(); };
  CHECK(eventually(guard_deadline, [&] { return listen() >= 132; }));
  listener.hang_up();
  bytes = 0;
  CHECK(eventually(guard_deadline, [&] { return listen() >= 132 + 70; }));
  CHECK(bytes == 132 + 70);
  ::kill(-program, SIGKILL);  // and all of its group
  CHECK(::waitpid(program, nullptr, 0) == program);
  const auto killed = std::chrono::steady_clock::now();

  PacketEar ear;
  ear.hear(std::span(run_packet).first(70));
  std::vector<Packet> heard;
  CHECK(eventually(guard_deadline, [&] {
    for (const Packet& packet : ear.hear(listener.read())) heard.push_back(packet);
    return !heard.empty() && heard.back() == wake_packet;
  }));
  CHECK(std::chrono::steady_clock::now() - killed < 2s);
  CHECK(eventually(guard_deadline, [&] {
    for (const Packet& packet : ear.hear(listener.read())) heard.push_back(packet);
    return heard.size() == 5;
  }));
  REQUIRE(heard.size() == 5);
  for (std::size_t i = 0; i < heard.size(); ++i) {
    if (i % 2 == 0)
      CHECK(heard[i][1] == static_cast<std::uint8_t>(PacketType::stop));
    else
      CHECK(heard[i] == wake_packet);
  }
}

TEST_CASE("pause guard: a lab that is started again at once gets the line") {
  PseudoTerminal terminal;
  int ends[2];
  REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
  const pid_t program = ::fork();
  if (program == 0) {
    const std::unique_ptr<ByteStream> line = guarded(make_byte_stream(terminal.port()));
    line->open();
    if (line->check() != ByteStream::State::open) ::_exit(1);
    ::close(ends[1]);
    for (;;) ::pause();
  }
  ::close(ends[1]);
  char nothing = 0;
  CHECK(::read(ends[0], &nothing, 1) == 0);
  ::close(ends[0]);
  CHECK_THROWS_AS(open_byte_stream(terminal.port()), PortError);
  ::kill(program, SIGKILL);
  CHECK(::waitpid(program, nullptr, 0) == program);
  CHECK(open_byte_stream(terminal.port())->check() == ByteStream::State::open);
}

TEST_CASE("pause guard: a guard that is sent away says nothing and lets the line go") {
  int ends[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  { const PauseGuard guard(ends[0]); }
  ::close(ends[0]);
  char said = 0;
  CHECK(::read(ends[1], &said, 1) == 0);  // the line's end: nobody holds it
  ::close(ends[1]);
}
