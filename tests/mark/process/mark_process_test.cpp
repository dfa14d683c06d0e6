// The programs as a user starts them: a lab, its gateway, the stand-in with its own, and an original on a real socket.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/mark/scripted_originals.hpp"
#include "tests/support/processes/process.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

constexpr std::uint16_t port = 7001;

sockaddr_in loopback() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

// An original with a socket: as the client it tries to connect without a pause, as the server it waits until somebody
// comes.
class SocketOriginal {
 public:
  explicit SocketOriginal(ScriptedOriginal& original) : original_(original) {}
  ~SocketOriginal() { close(); }
  bool connect() {
    const sockaddr_in to = loopback();
    return eventually(300s, [&] {
      close();
      socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
      return ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
    });
  }
  bool accept() {
    const int listening = ::socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in here = loopback();
    if (::bind(listening, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) return false;
    ::listen(listening, 1);
    socket_ = ::accept(listening, nullptr, nullptr);
    ::close(listening);
    return socket_ >= 0;
  }
  // One tick. False: the other end has closed, which would have killed it.
  bool tick() {
    char bytes[4096];
    const ssize_t n = ::recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT);
    if (n > 0) original_.receive({bytes, static_cast<std::size_t>(n)});
    const std::string text = original_.tick();
    return n != 0 && ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  void close() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }

 private:
  ScriptedOriginal& original_;
  int socket_ = -1;
};

// Gateways and labs of experiments/mark/dhtf.
class Programs {
 public:
  Programs(const std::string& role, std::vector<std::string> sets) : sets_(std::move(sets)) {
    for (const char* lab : {"shark", "argos"}) start(lab, "gateway", {});
    start("shark", "lab", {"--out", out("shark")});
    start("argos", "mark", {role, "--out", out("argos")});
  }
  Process& of(const std::string& lab, const std::string& command) { return *processes_.at(lab + command); }
  // Of a lab's result.json, which is there from the run's beginning.
  nlohmann::json result(const std::string& lab) const {
    std::ifstream in(out(lab) + "/result.json");
    return nlohmann::json::parse(in, nullptr, false);
  }
  bool comes_to(const std::string& lab, const std::string& outcome) const {
    const nlohmann::json json = result(lab);
    return !json.is_discarded() && json.value("outcome", json.value("state", "")) == outcome;
  }

 private:
  std::string out(const std::string& lab) const { return (folder_.path() / lab).string(); }
  void start(const std::string& lab, const std::string& command, const std::vector<std::string>& more) {
    std::vector<std::string> all = {command, (experiments() / "mark" / "dhtf" / (lab + ".toml")).string()};
    for (const std::string& set : sets_) all.insert(all.end(), {"--set", set});
    all.insert(all.end(), more.begin(), more.end());
    processes_[lab + command] =
        std::make_unique<Process>(ARKMESH_PROGRAM, all, folder_.path() / (lab + "-" + command + ".txt"));
  }
  TemporaryFolder folder_;
  std::vector<std::string> sets_;
  std::map<std::string, std::unique_ptr<Process>> processes_;
};

// Ticks of an original at 20 times real time, or so long each, until `condition` or until the other end closes.
template <class Condition>
bool tick_until(SocketOriginal& socket, Condition condition, std::chrono::microseconds tick = 5ms) {
  const auto until = std::chrono::steady_clock::now() + 300s;
  while (!condition()) {
    if (!socket.tick() || std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(tick);
  }
  return true;
}

// One of both sides is stopped for a while, as by SIGSTOP; nobody: the original.
struct Stop {
  const char* lab;
  const char* command;
  std::chrono::seconds length;
};

// Both sides have the same tasks at the end, or the log says why they have not.
void check_stops(bool is_server, std::chrono::microseconds tick, const std::vector<Stop>& stops) {
  CAPTURE(is_server);
  CAPTURE(tick.count());
  DhtfOriginalClient client(1);
  DhtfOriginalServer server(2, "Ibcghijko0000000000000000");
  ScriptedOriginal& original = is_server ? static_cast<ScriptedOriginal&>(server) : client;
  SocketOriginal socket(original);
  Programs programs(is_server ? "--client" : "--server", {"run.duration_s=120", "scenario.dhtf.types=easy",
                                                          is_server ? "shared.owner=argos" : "shared.owner=shark"});
  REQUIRE((is_server ? socket.accept() : socket.connect()));
  Process& stand_in = programs.of("argos", "mark");
  const auto begun = [&] { return stand_in.output().find("lab time starts") != std::string::npos; };
  REQUIRE(tick_until(socket, begun, tick));
  for (const Stop& stop : stops) {
    CAPTURE(stop.command);
    CAPTURE(stop.length.count());
    // For 20 s of its time all goes well, and then not.
    const std::uint64_t then = original.ticks + 200;
    REQUIRE(tick_until(
        socket, [&] { return original.ticks >= then; }, tick));
    const auto until = std::chrono::steady_clock::now() + stop.length;
    const auto over = [&] { return std::chrono::steady_clock::now() >= until; };
    if (!stop.lab) {
      std::this_thread::sleep_until(until);
      continue;
    }
    programs.of(stop.lab, stop.command).signal(SIGSTOP);
    CHECK(tick_until(socket, over, tick));
    programs.of(stop.lab, stop.command).signal(SIGCONT);
  }
  INFO(stand_in.output());
  INFO(programs.of("shark", "lab").output());
  REQUIRE(tick_until(
      socket, [&] { return stand_in.output().find("is still running") != std::string::npos; }, tick));
  CHECK(tick_until(
      socket, [&, then = original.ticks + 20] { return original.ticks >= then; }, tick));
  CHECK(programs.comes_to("argos", "finished"));
  const std::uint64_t known = programs.result("argos").at("counts").at("completed");
  std::size_t unknown = 0;
  const std::string log = stand_in.output();
  for (std::size_t at = 0; (at = log.find("after the labs had ended", at)) != std::string::npos; ++at) ++unknown;
  CHECK(known + unknown == original.done.size());
  CHECK(known > 5);
  socket.close();
  CHECK(stand_in.wait(300s) == 0);
  CHECK(programs.of("shark", "lab").wait(300s) == 0);
  CHECK(programs.result("shark").at("counts").at("completed") == known);
  CHECK(original.cut_reads == 0);
}

}  // namespace

TEST_CASE("the programs with an original client: both finish, and it is never closed on") {
  // The client connects before anybody listens. When both labs have finished, its connection stays until it goes.
  DhtfOriginalClient original(1);
  SocketOriginal socket(original);
  Programs programs("--server", {"run.duration_s=40"});
  REQUIRE(socket.connect());
  Process& stand_in = programs.of("argos", "mark");
  CHECK(tick_until(socket, [&] { return programs.of("shark", "lab").wait(0ms).has_value(); }));
  INFO(stand_in.output());
  INFO(programs.of("shark", "lab").output());
  CHECK(programs.of("shark", "lab").wait(0ms) == 0);
  CHECK(tick_until(
      socket, [&] { return stand_in.output().find("the original program is still running") != std::string::npos; }));
  const std::uint64_t before = original.ticks;
  CHECK(tick_until(socket, [&] { return original.ticks > before + 100; }));
  CHECK(stand_in.running());
  socket.close();
  CHECK(stand_in.wait(300s) == 0);
  CHECK(original.sites.size() == 8);
  CHECK(original.cut_reads == 0);
  CHECK(original.most_unread <= 30);
  CHECK(programs.result("argos").at("arena").at("platform") == "m-ark");
  CHECK(programs.result("argos").at("counts").at("completed") == programs.result("shark").at("counts").at("completed"));
}

TEST_CASE("the programs with an original server that is killed: both end by name") {
  DhtfOriginalServer original(2, "Ibcghijko0100101101011100");
  SocketOriginal socket(original);
  Programs programs("--client", {"run.duration_s=900", "shared.owner=argos", "gate.on_peer_lost=end"});
  REQUIRE(socket.accept());  // it waits for a client, and for nothing else
  REQUIRE(tick_until(socket, [&] { return original.levels_sent > 60; }));
  socket.close();
  Process& stand_in = programs.of("argos", "mark");
  CHECK(stand_in.wait(300s) == 1);
  CHECK(stand_in.output().find("the original M-ARK server (ARGoS), which is disconnected") != std::string::npos);
  CHECK(programs.of("shark", "lab").wait(300s) == 1);
  CHECK(programs.of("shark", "lab").output().find("argos") != std::string::npos);
}

TEST_CASE("the programs, any of which stands still: both sides have done the same") {
  if (!thorough()) return check_stops(false, 5ms, {{"shark", "lab", 2s}, {"argos", "mark", 2s}});
  for (const bool is_server : {false, true})
    for (const std::chrono::microseconds tick : {100'000us, 2500us})
      for (const auto length : {3s, 8s, 20s})
        check_stops(is_server, tick,
                    {{"shark", "lab", length},
                     {"argos", "mark", length},
                     {"argos", "gateway", length},
                     {"shark", "gateway", length},
                     {nullptr, "the original", length}});
}

TEST_CASE("an operator ends the lab, and the original is still not closed on") {
  // SIGTERM ends the lab with its results. The process stays for the original's sake, and goes with it.
  DhtfOriginalClient original(1);
  SocketOriginal socket(original);
  Programs programs("--server", {"run.duration_s=900"});
  REQUIRE(socket.connect());
  REQUIRE(tick_until(socket, [&] { return !original.sites.empty() && original.active.size() == 8; }));
  Process& stand_in = programs.of("argos", "mark");
  stand_in.signal(SIGTERM);
  CHECK(tick_until(
      socket, [&] { return stand_in.output().find("the original program is still running") != std::string::npos; }));
  CHECK(stand_in.output().find("stopped by the operator") != std::string::npos);
  const std::uint64_t before = original.ticks;
  CHECK(tick_until(socket, [&] { return original.ticks > before + 100; }));
  CHECK(stand_in.running());
  socket.close();
  CHECK(stand_in.wait(300s) == 3);
}

TEST_CASE("a stand-in that cannot agree with the original ends with the code of a wrong configuration") {
  DhtfOriginalServer original(2, "Ibcghij010010110101");
  SocketOriginal socket(original);
  Programs programs("--client", {"shared.owner=argos"});
  REQUIRE(socket.accept());
  Process& stand_in = programs.of("argos", "mark");
  CHECK(tick_until(socket, [&] { return stand_in.output().find("is still running") != std::string::npos; }));
  socket.close();
  CHECK(stand_in.wait(300s) == 2);
  CHECK(stand_in.output().find("scenario.dhtf.sites = 8") != std::string::npos);
  CHECK(stand_in.output().find("has 6 sites") != std::string::npos);
}

TEST_CASE("arkmesh mark says what is wrong with its command line") {
  const TemporaryFolder folder;
  const std::string file = (experiments() / "mark" / "dhtf" / "argos.toml").string();
  struct Case {
    std::vector<std::string> arguments;
    std::string words;
    int code;
  };
  const std::vector<Case> cases = {
      {{"mark", file}, "give --server if the original is M-ARK's client", 2},
      {{"mark", file, "--server", "--client"}, "excludes", 2},
      {{"mark", file + ".none", "--server"}, "there is no file", 2},
      {{"mark", "--keys"}, "allow_plaintext", 0},
      {{"mark", "--help"}, "Examples", 0},
      {{"mark", file, "--server", "--set", "mark.adress=127.0.0.1"}, "mark.address", 2},
      {{"mark", file, "--server", "--set", "mark.address=0.0.0.0"}, "mark.allow_plaintext = true", 2},
  };
  for (const Case& one : cases) {
    Process process(ARKMESH_PROGRAM, one.arguments, folder.path() / "out.txt");
    CHECK(process.wait(300s) == one.code);
    CHECK_MESSAGE(process.output().find(one.words) != std::string::npos, process.output());
  }
}
