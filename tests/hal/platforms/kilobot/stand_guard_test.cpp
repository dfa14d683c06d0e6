// What reaches an overhead controller after the program that drove it is gone, and who may drive it meanwhile.
#include "hal/platforms/kilobot/stand_guard.hpp"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/platforms/kilobot/kilobot_arena.hpp"
#include "hal/platforms/kilobot/packet.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"
#include "tests/support/kilobot/listener.hpp"
#include "tests/support/kilobot/packet_ear.hpp"
#include "tests/support/processes/process.hpp"
#include "tests/support/processes/pseudo_terminal.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds guard_deadline = 300s;
using GuardKind = hal::FleetCommand::Kind;

// A process that does something and then waits to be killed, with all of its group.
class Victim {
 public:
  explicit Victim(const std::function<void()>& act) {
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    process_ = ::fork();
    if (process_ == 0) {
      ::setpgid(0, 0);
      act();
      ::close(ends[1]);
      for (;;) ::pause();
    }
    ::close(ends[1]);
    char nothing = 0;
    CHECK(::read(ends[0], &nothing, 1) == 0);  // it has done it
    ::close(ends[0]);
  }
  ~Victim() { kill(); }
  void kill() {
    if (process_ < 0) return;
    ::kill(-process_, SIGKILL);
    ::waitpid(std::exchange(process_, -1), nullptr, 0);
  }

 private:
  pid_t process_;
};

// With a guard that was told this.
Victim guarded(const std::string& port, std::vector<StandGuard::State> states) {
  return Victim([&] {
    auto* const guard = new StandGuard(port);  // nobody destroys it
    for (const auto& state : states) guard->tell(state);
  });
}

// The types of messages that were said, one after another, and "stop".
struct GuardEar {
  explicit GuardEar(Listener& line) : listener(line) {}
  void listen() {
    for (const Packet& packet : ear.hear(listener.read())) heard.push_back(packet);
  }
  bool hears(std::uint8_t type) {
    listen();
    return std::ranges::any_of(heard, [&](const Packet& packet) {
      return packet[1] == static_cast<std::uint8_t>(PacketType::forward) && packet[11] == type;
    });
  }
  Listener& listener;
  PacketEar ear;
  std::vector<Packet> heard;
};

bool port_is_free(const std::string& port) {
  try {
    const PortLock lock(port, "arkmesh-guard of a test");  // as a guard it sends none away
    return true;
  } catch (const PortError&) {
    return false;
  }
}

}  // namespace

TEST_CASE("stand guard: robots of a program that is killed are told to stand, for as long as they may walk") {
  Listener listener;
  Victim program = guarded(listener.port(), {{GuardKind::pause, true, false}, {GuardKind::pause, false, false}});
  program.kill();
  const auto killed = std::chrono::steady_clock::now();
  GuardEar ear(listener);
  CHECK(eventually(guard_deadline, [&] { return ear.hears(type_wakeup); }));
  CHECK(eventually(guard_deadline, [&] {
    ear.listen();
    return std::chrono::steady_clock::now() - killed > 5s;
  }));
  CHECK_FALSE(port_is_free(listener.port()));
  // whoever wants the port gets it at once
  const auto stream = claim_byte_stream(listener.port(), "lab shark");
  ear.listen();
  ear.heard.clear();
  std::this_thread::sleep_for(1s);
  ear.listen();
  CHECK(ear.heard.empty());
}

TEST_CASE("stand guard: a line that comes back later is found") {
  Listener listener;
  listener.stop();
  guarded(listener.port(), {{GuardKind::sleep, false, false}}).kill();
  std::this_thread::sleep_for(2s);
  listener.listen_again();
  GuardEar ear(listener);
  CHECK(eventually(guard_deadline, [&] { return ear.hears(type_sleep); }));  // robots that sleep are not woken
  CHECK_FALSE(ear.hears(type_wakeup));
  const PortLock lock(listener.port(), "the test");  // sends it away
}

TEST_CASE("stand guard: where robots were seen to stand it leaves soon, and after an orderly end at once") {
  Listener listener;
  guarded(listener.port(), {{GuardKind::pause, true, false}}).kill();
  const auto killed = std::chrono::steady_clock::now();
  GuardEar ear(listener);
  CHECK(eventually(guard_deadline, [&] { return ear.hears(type_wakeup); }));
  CHECK(eventually(guard_deadline, [&] {
    ear.listen();
    return port_is_free(listener.port());
  }));
  CHECK(std::chrono::steady_clock::now() - killed <
        50s);  // three when nothing else runs, and a minute for robots that walk
  CHECK(ear.heard.back()[1] == static_cast<std::uint8_t>(PacketType::stop));

  Listener other;
  guarded(other.port(), {{GuardKind::pause, true, true}}).kill();
  std::this_thread::sleep_for(1s);
  CHECK(other.read().empty());
}

TEST_CASE("port lock: a second program on one controller is refused by the first one's name") {
  PseudoTerminal terminal;
  Listener listener;
  for (const std::string& port : {terminal.port(), listener.port()}) {
    CAPTURE(port);
    Victim program([&] { new PortLock(port, "lab shark"); });
    try {
      const auto stream = open_byte_stream(port, "roark");
      FAIL("two programs have the port");
    } catch (const PortError& refused) {
      CHECK(std::string(refused.what()).find(port + " is driven by lab shark (process ") == 0);
    }
    program.kill();
    CHECK(open_byte_stream(port, "roark") != nullptr);
  }
}
