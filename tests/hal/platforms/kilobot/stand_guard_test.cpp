// What reaches an overhead controller after the program that drove it is gone, and who may drive it meanwhile.
#include "hal/platforms/kilobot/stand_guard.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
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

// A process that does something and then does what goes on, each millisecond, until it is killed with all of its group.
class Victim {
 public:
  explicit Victim(const std::function<void()>& act, const std::function<void()>& goes_on = {}) {
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    process_ = ::fork();
    if (process_ == 0) {
      ::setpgid(0, 0);
      act();
      ::close(ends[1]);
      for (;; std::this_thread::sleep_for(1ms)) goes_on ? goes_on() : static_cast<void>(::pause());
    }
    ::close(ends[1]);
    char nothing = 0;
    CHECK(::read(ends[0], &nothing, 1) == 0);  // it has done it
    ::close(ends[0]);
  }
  ~Victim() { kill(); }
  void signal(int number) { ::kill(process_, number); }
  bool is_there() { return process_ > 0 && ::waitpid(process_, nullptr, WNOHANG) == 0; }
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
    new PortLock(port, "lab shark");  // nobody destroys them
    auto* const guard = new StandGuard(port);
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
  PortLock(listener.port(), "the test").take_over();  // sends it away
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

TEST_CASE("stand guard: a program that wants the port and reaches nobody leaves the guard in its place") {
  // However it ends: it gives up, or is killed in mid-try. The line may be there or not meanwhile.
  PseudoTerminal terminal;
  Listener listener;
  for (const bool is_killed : {false, true}) {
    CAPTURE(is_killed);
    guarded(listener.port(), {{GuardKind::pause, false, false}}).kill();
    GuardEar ear(listener);
    REQUIRE(eventually(guard_deadline, [&] { return ear.hears(type_wakeup); }));
    if (is_killed) {
      Victim tries([&] { new PortLock(listener.port(), "arkmesh ohc"); });
      CHECK_FALSE(port_is_free(listener.port()));
      tries.kill();
    } else {
      listener.stop();
      std::shared_ptr<PortLock> lock;
      const auto stream = claim_byte_stream(listener.port(), "arkmesh ohc", &lock);
      stream->open();
      CHECK(eventually(guard_deadline, [&] { return stream->check() == ByteStream::State::closed; }));
      CHECK(lock->guarded_words().find("arkmesh-guard") != std::string::npos);
    }
    if (!is_killed) listener.listen_again();
    listener.hang_up();
    ear.heard.clear();
    CHECK(eventually(guard_deadline, [&] { return ear.hears(type_wakeup); }));
    // One that robots have heard takes its place.
    {
      std::shared_ptr<PortLock> lock;
      const auto stream = claim_byte_stream(listener.port(), "arkmesh ohc", &lock);
      lock->take_over();
      CHECK(eventually(guard_deadline, [&] { return lock->guarded_words().empty(); }));
    }
    CHECK(port_is_free(listener.port()));
  }
}

TEST_CASE("stand guard: robots of a program that hangs are told to stand, on its own line") {
  Listener listener;
  Victim* program = nullptr;
  const auto start = [&](std::chrono::milliseconds hung_after) {
    const auto guard = std::make_shared<std::shared_ptr<StandGuard>>();
    const auto stream = std::make_shared<std::unique_ptr<ByteStream>>();
    const auto idle = std::make_shared<int>(0);
    program = new Victim(
        [&listener, guard, stream, hung_after] {
          listener.stop();  // this process's copies
          *guard = std::make_shared<StandGuard>(listener.port(), hung_after);
          *stream = claim_byte_stream(listener.port(), "lab shark", nullptr, *guard);
          (*stream)->open();
        },
        [guard, stream, idle] {
          (*guard)->tell({GuardKind::pause, false, false, true});
          // four times a second, as a lab does: who tries more often meets itself at a port that nobody listens at
          if ((*stream)->check() == ByteStream::State::closed && ++*idle % 250 == 0) (*stream)->open();
          const std::array<std::uint8_t, 1> sign{'.'};
          (*stream)->write(sign);
        });
  };
  start(1s);
  GuardEar ear(listener);
  const auto says_dots = [&] { return std::ranges::count(listener.read(), '.') > 0; };
  REQUIRE(eventually(guard_deadline, says_dots));
  std::this_thread::sleep_for(500ms);  // it shows that it lives
  program->signal(SIGSTOP);
  REQUIRE(eventually(guard_deadline, [&] { return ear.hears(type_wakeup); }));
  const auto holder = port_holder(listener.port());
  REQUIRE(holder);
  CHECK(holder->state == PortHolder::State::hung);
  CHECK_THROWS_WITH_AS(PortLock(listener.port(), "arkmesh ohc"), doctest::Contains("hangs"), PortTaken);
  // Nothing of the program's own comes on that line any more; it opens another.
  program->signal(SIGCONT);
  std::vector<std::uint8_t> rest;
  std::vector<std::uint8_t> last;
  CHECK(eventually(guard_deadline, [&] {
    for (const std::uint8_t byte : listener.read()) rest.push_back(byte);
    return port_holder(listener.port())->state == PortHolder::State::speaking;
  }));
  std::this_thread::sleep_for(200ms);
  for (const std::uint8_t byte : listener.read()) rest.push_back(byte);
  CHECK(std::search_n(rest.begin(), rest.end(), 3, std::uint8_t{'.'}) == rest.end());
  listener.hang_up();
  CHECK(eventually(guard_deadline, says_dots));
  // Where it has no line, and so nobody can speak, it is ended.
  listener.stop();
  std::this_thread::sleep_for(500ms);
  program->signal(SIGSTOP);
  CHECK(eventually(guard_deadline, [&] { return !program->is_there(); }));
  listener.listen_again();
  ear.heard.clear();
  CHECK(eventually(guard_deadline, [&] { return ear.hears(type_wakeup); }));
  delete program;
  PortLock(listener.port(), "the test").take_over();
}

TEST_CASE("port lock: a stranger's lock is named by who has it, not by what its file says") {
  Listener listener;
  { const PortLock mine(listener.port(), "lab shark"); }
  Victim stranger([&] {
    for (const auto& each :
         std::filesystem::directory_iterator(std::filesystem::exists("/run/lock") ? "/run/lock" : "/tmp"))
      if (const auto name = each.path().filename().string();
          name.starts_with("arkmesh-port-") &&
          name.find(listener.port().substr(listener.port().rfind(':') + 1)) != std::string::npos)
        ::flock(::open(each.path().c_str(), O_RDWR), LOCK_EX);
  });
  CHECK_THROWS_WITH_AS(PortLock(listener.port(), "arkmesh ohc"), doctest::Contains("is locked by process"), PortTaken);
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
