// `arkmesh gateway` as a user starts it: real processes on real LCM ports.
#include "gateway/gateway_process.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "gateway/links/links.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/bus/bus.hpp"
#include "hal/handle.hpp"
#include "tests/support/network/raw_peer.hpp"
#include "tests/support/processes/process.hpp"

namespace {

using namespace arkmesh;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

constexpr int shark_port = 7846, roark_port = 7847, free_port = 7848;

std::string url(int port) {
  return fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", port);
}

// Two labs' configuration files; shark listens.
struct Files {
  TemporaryFolder folder;

  std::string write(const std::string& lab, int lcm_port, const std::string& gateway) const {
    const auto file = folder.path() / (lab + ".toml");
    std::ofstream(file) << fmt::format(
        "[lab]\nname = \"{}\"\n[bus]\nurl = \"{}\"\n[shared]\nlabs = [\"roark\", \"shark\"]\n[gateway]\n{}\n"
        "[arena]\nuse = \"what only the lab knows\"\n",
        lab, url(lcm_port), gateway);
    return file.string();
  }
  const std::string shark =
      write("shark", shark_port, fmt::format("listen = \"127.0.0.1:{}\"\npeers = [{{lab = \"roark\"}}]", shark_port));
  const std::string roark =
      write("roark", roark_port, fmt::format("peers = [{{lab = \"shark\", connect = \"127.0.0.1:{}\"}}]", shark_port));

  Process start(const std::string& file, const std::string& name, const std::vector<std::string>& sets = {}) const {
    std::vector<std::string> arguments = {"gateway", file};
    for (const std::string& set : sets) arguments.insert(arguments.end(), {"--set", set});
    return Process(ARKMESH_PROGRAM, arguments, folder.path() / (name + ".txt"));
  }
};

bool says(Process& process, const std::string& text, std::chrono::seconds deadline = 40s) {
  return eventually(deadline, [&] { return process.output().find(text) != std::string::npos || !process.running(); }) &&
         process.output().find(text) != std::string::npos;
}

TEST_CASE("two gateway processes join two labs") {
  // Messages cross both ways under the sender's name, the processes say what they do, and SIGTERM and SIGINT end them
  // with 0.
  const Files files;
  Process shark = files.start(files.shark, "shark"), roark = files.start(files.roark, "roark");
  REQUIRE(says(shark, "gateway of shark: listening on 127.0.0.1:7846\n"));
  REQUIRE(says(roark, "gateway of roark: connecting to shark at 127.0.0.1:7846\n"));
  REQUIRE(says(shark, "gateway of shark: roark connected\n"));
  REQUIRE(says(roark, "gateway of roark: shark connected\n"));

  hal::Bus at_shark(url(shark_port)), at_roark(url(roark_port));
  std::string heard;
  peers_t peers;
  const auto world = at_roark.subscribe("shark/world", [&](std::string_view, auto bytes) {
    heard.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
  const auto status = at_roark.subscribe("peers", [&](std::string_view, auto bytes) { hal::decode(bytes, peers); });
  at_shark.publish("world", std::as_bytes(std::span("some state")));
  CHECK(eventually(300s, [&] {
    at_roark.drain(50ms);
    return heard == std::string("some state", 11);
  }));
  CHECK(eventually(300s, [&] {
    at_roark.drain(50ms);
    return peers.lab == "roark" && peers.peers.size() == 1 && peers.peers[0].up && peers.peers[0].channels.size() == 1;
  }));
  CHECK(peers.peers[0].version == ARKMESH_VERSION);
  CHECK(peers.peers[0].channels[0].channel == "shark/world");
  CHECK(peers.peers[0].channels[0].messages == 1);
  CHECK(peers.peers[0].channels[0].bytes == 11);

  shark.signal(SIGTERM);
  CHECK(shark.wait(300s) == 0);
  CHECK(says(roark, "gateway of roark: shark not connected: "));
  roark.signal(SIGINT);
  CHECK(roark.wait(300s) == 0);
}

TEST_CASE("a gateway that was left running by another experiment is refused by name") {
  // Both sides say what the other belongs to. What a gateway belongs to is its file's scenario, or what the file says.
  const Files files;
  Process shark = files.start(files.shark, "shark", {"run.scenario=\"dhtf\""});
  Process roark = files.start(files.roark, "roark", {"run.scenario=\"dhtf\"", "shared.experiment=\"last week\""});
  CHECK(says(shark,
             "gateway of roark belongs to experiment 'last week', this one to 'dhtf'; end that gateway, or set "
             "shared.experiment alike\n",
             300s));
  CHECK(says(roark, "gateway of shark belongs to experiment 'dhtf', this one to 'last week'", 300s));
}

TEST_CASE("arkmesh explain says which rule lets a channel pass, or why none does") {
  // Both sides' rules count; the exit code is 0 when it passes, 1 when it does not, 2 when the question is wrong.
  const Files files;
  int runs = 0;
  const auto explained = [&](int code, std::vector<std::string> words) {
    words.insert(words.begin(), "explain");
    Process process(ARKMESH_PROGRAM, words, files.folder.path() / fmt::format("explain{}.txt", runs++));
    CHECK(process.wait(300s) == code);
    return process.output();
  };
  CHECK(explained(0, {"world", "--to", "roark", files.shark, files.roark})
            .find("lab roark imports world from shark as shark/world: rule 3") != std::string::npos);
  CHECK(explained(1, {"poses", "--from", "roark", files.shark}).find("add \"poses\" to gateway.imports in ") !=
        std::string::npos);
  CHECK(explained(2, {"world", "--to", "lynx", files.shark}).find("lab shark has no peer lynx") != std::string::npos);
}

TEST_CASE("arkmesh reload changes the rules of a gateway at work") {
  // The link stays, the peer gets what the file allows now; a wrong file changes nothing and says why; what needs a new
  // start is named. Nobody is asked who does not run with the file.
  const Files files;
  Process shark = files.start(files.shark, "shark"),
          roark = files.start(files.roark, "roark", {"gateway.imports=[\"*\"]"});
  REQUIRE(says(shark, "roark connected", 300s));
  int runs = 0;
  const auto reload = [&](int code, const std::string& file) {
    Process process(ARKMESH_PROGRAM, {"reload", file}, files.folder.path() / fmt::format("reload{}.txt", runs++));
    CHECK(process.wait(300s) == code);
    return process.output();
  };
  const std::string gateway = "peers = [{lab = \"roark\"}]\nexports = [\"cam_*\"]\n";
  files.write("shark", shark_port, gateway + "listen = \"127.0.0.1:1\"");
  const std::string said = reload(0, files.shark);
  CHECK(said.starts_with("gateway of shark: 3 rules are in force, as shark.toml says now\n"));
  CHECK(said.ends_with("effective only after a restart: gateway.listen\n"));
  REQUIRE(says(shark, "gateway of shark: 3 rules are in force, as shark.toml says now\n", 300s));
  CHECK(says(shark, "effective only after a restart: gateway.listen\n", 300s));
  files.write("shark", shark_port, gateway + "listen = \"127.0.0.1:1\"\nlisen = \"\"");
  CHECK(reload(2, files.shark).find("unknown key 'gateway.lisen'") != std::string::npos);
  shark.signal(SIGHUP);
  CHECK(says(shark, "gateway of shark: the rules are unchanged: ", 300s));

  hal::Bus at_shark(url(shark_port)), at_roark(url(roark_port));
  bool heard = false;
  const auto camera = at_roark.subscribe("shark/cam_1", [&](std::string_view, auto) { heard = true; });
  CHECK(eventually(300s, [&] {
    at_shark.publish("cam_1", std::as_bytes(std::span("a picture")));
    at_roark.drain(50ms);
    return heard;
  }));
  CHECK(shark.output().find("not connected") == std::string::npos);
  roark.kill();
  CHECK(reload(1, files.roark).find("arkmesh: none of your gateways runs with ") == 0);
}

TEST_CASE("arkmesh reload reaches the gateway although others hold sockets with its name") {
  // One of them takes no connection any more, and would block who connects; another one takes it and says nothing.
  const Files files;
  Process shark = files.start(files.shark, "shark");
  REQUIRE(says(shark, "listening on", 300s));
  const std::string path = std::filesystem::weakly_canonical(files.shark).string();
  std::vector<hal::Handle> held;
  const auto named = [&](const std::string& digits) {
    sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
    const std::string name =
        "arkmesh-gateway-" + digits + path.substr(path.size() - std::min<std::size_t>(path.size(), 70));
    name.copy(address.sun_path + 1, sizeof address.sun_path - 1);
    return std::pair(address, static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size()));
  };
  for (const std::string digits : {"00000000ffffffff", "11111111ffffffff"}) {
    const auto [address, size] = named(digits);
    const auto* const to = reinterpret_cast<const sockaddr*>(&address);
    held.emplace_back(::socket(AF_UNIX, SOCK_STREAM, 0));
    REQUIRE(::bind(held.back().get(), to, size) == 0);
    REQUIRE(::listen(held.back().get(), digits[0] == '0' ? 0 : 10) == 0);
    for (int connected = 0; digits[0] == '0' && connected == 0;) {
      held.emplace_back(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0));
      connected = ::connect(held.back().get(), to, size);
    }
  }
  Process process(ARKMESH_PROGRAM, {"reload", files.shark}, files.folder.path() / "reload.txt");
  CHECK(process.wait(300s) == 0);
  const std::string said = process.output();
  CHECK(said.find("gateway of shark: 4 rules are in force, as shark.toml says now\n") != std::string::npos);
  CHECK(said.find("a gateway has not answered within 5 s; send it SIGHUP to reload its rules\n") != std::string::npos);
  CHECK(said.find("1 socket with the name of this file's gateways accepted no connection within 2 s; ") !=
        std::string::npos);
  shark.kill();
  shark.wait(300s);
  held.pop_back();  // the one that says nothing
  Process alone(ARKMESH_PROGRAM, {"reload", files.shark}, files.folder.path() / "alone.txt");
  CHECK(alone.wait(300s) == 1);
  CHECK(alone.output().starts_with("arkmesh: 1 socket with the name of this file's gateways accepted no connection"));
}

TEST_CASE("two labs that have never met are joined over TLS") {
  // As docs/security.md tells it: a key for each lab, each other's certificate, one line of configuration. Without a
  // key a gateway does not start, and says how to make one.
  const Files files;
  const std::string keys = (files.folder.path() / "keys").string();
  int runs = 0;
  const auto said = [&](int code, std::vector<std::string> words) {
    words.insert(words.begin(), "keys");
    words.insert(words.end(), {"--keys", keys});
    Process process(ARKMESH_PROGRAM, words, files.folder.path() / fmt::format("keys{}.txt", runs++));
    CHECK(process.wait(300s) == code);
    return process.output();
  };
  const std::string common = fmt::format("keys = \"{}\"\n", keys);
  const std::string shark_file =
      files.write("shark", shark_port,
                  common + fmt::format("listen = \"tls://0.0.0.0:{}\"\npeers = [{{lab = \"roark\"}}]", shark_port));
  const std::string roark_file =
      files.write("roark", roark_port,
                  common + fmt::format("peers = [{{lab = \"shark\", connect = \"tls://localhost:{}\"}}]", shark_port));
  Process keyless = files.start(shark_file, "keyless");
  CHECK(keyless.wait(300s) == 2);
  CHECK(keyless.output().find("create them with: arkmesh keys init shark") != std::string::npos);

  const std::string made = said(0, {"init", "shark"});
  CHECK(made.find("fingerprint  ") != std::string::npos);
  said(0, {"init", "roark"});
  CHECK(said(2, {"init", "roark"}).find("arkmesh: lab roark already has a key in ") == 0);
  said(0, {"trust", keys + "/roark.crt"});
  const std::string trusted = said(0, {"trust", keys + "/shark.crt"});
  const std::size_t digits = made.find("fingerprint"), line = made.find('\n', digits);
  CHECK(trusted.find(made.substr(digits, line - digits)) != std::string::npos);

  Process shark = files.start(shark_file, "shark"), roark = files.start(roark_file, "roark");
  REQUIRE(says(shark, fmt::format("gateway of shark: listening on tls://0.0.0.0:{}\n", shark_port), 300s));
  REQUIRE(says(shark, "gateway of shark: roark connected\n", 300s));
  REQUIRE(says(roark, "gateway of roark: shark connected\n", 300s));
  CHECK(said(0, {"revoke", "roark"}).find("lab roark is no longer trusted") == 0);
  CHECK(says(shark, "roark not connected: the certificate of lab roark was revoked here", 300s));
  CHECK(said(0, {"list"}).find("revoked  roark") != std::string::npos);
  CHECK(said(2, {"revoke", "roark"}).find("nothing to revoke") != std::string::npos);
}

TEST_CASE("a gateway killed with SIGKILL comes back") {
  // Started again it is not confused by its own leftovers: it is back.
  const Files files;
  Process roark = files.start(files.roark, "roark");
  for (int start = 0; start < 3; ++start) {
    Process shark = files.start(files.shark, "shark" + std::to_string(start));
    REQUIRE(says(shark, "roark connected"));
    shark.kill();
  }
}

TEST_CASE("a second gateway of a lab gives way") {
  // Only the newcomer ends, with 2 and a sentence; the first one goes on undisturbed.
  const Files files;
  Process shark = files.start(files.shark, "shark"), roark = files.start(files.roark, "roark");
  REQUIRE(says(shark, "roark connected"));
  Process second = files.start(files.roark, "second");
  CHECK(second.wait(300s) == 2);
  CHECK(second.output() ==
        fmt::format("arkmesh: bus {}: another gateway of lab roark runs already; stop it first\n", url(roark_port)));
  CHECK(shark.running());
  CHECK(roark.running());
  CHECK(shark.output().find("not connected") == std::string::npos);
}

TEST_CASE("of two gateways of a lab started together one stays") {
  // Whoever is later gives way, also when it has taken the TCP port first: the lab is never left without a gateway.
  const Files files;
  for (int turn = 0; turn < 5; ++turn) {
    CAPTURE(turn);
    Process one = files.start(files.shark, fmt::format("one{}", turn));
    Process other = files.start(files.shark, fmt::format("other{}", turn));
    CHECK(eventually(300s, [&] { return one.running() != other.running(); }));
    Process& last = one.running() ? one : other;
    CHECK(says(last, "listening"));
    Process& first = one.running() ? other : one;
    const int code = first.wait(300s).value_or(-1);
    CAPTURE(code);
    const std::string said = first.output();
    CAPTURE(said);
    CHECK((code == 2 || said.find("is in use by another program") != std::string::npos));  // it may see the port first
    CHECK(last.running());
  }
}

TEST_CASE("a gateway listens at once") {
  // Asking whether another one is here keeps it from connecting to its peers for 300 ms, not from being connected to.
  // Of some starts, because a busy machine may look too late.
  const Files files;
  const std::string file =
      files.write("lynx", free_port,
                  fmt::format("listen = \"127.0.0.1:{}\"\npeers = [{{lab = \"shark\"}}, {{lab = \"roark\", connect = "
                              "\"127.0.0.1:{}\"}}]",
                              free_port, roark_port));
  bool at_once = false;
  for (int start = 0; start < 5 && !at_once; ++start) {
    Process lynx = files.start(file, fmt::format("lynx{}", start), {"shared.labs=[\"lynx\", \"roark\", \"shark\"]"});
    REQUIRE(says(lynx, "listening"));
    at_once = lynx.output().find("connecting") == std::string::npos;
    REQUIRE(says(lynx, "connecting to roark"));
  }
  CHECK(at_once);
}

TEST_CASE("a second gateway that listens on a taken port says who has it") {
  // The port is the first one's, so the first one's answer is waited for.
  const Files files;
  Process shark = files.start(files.shark, "shark");
  REQUIRE(says(shark, "listening"));
  Process second = files.start(files.shark, "second");
  CHECK(second.wait(300s) == 2);
  CHECK(second.output() ==
        fmt::format("arkmesh: bus {}: another gateway of lab shark runs already; stop it first\n", url(shark_port)));
  CHECK(shark.running());
}

TEST_CASE("another lab on our LCM port is refused") {
  // A lab process, or another lab's gateway, that was there before is named, with what to do.
  const Files files;
  const std::string sentence =
      fmt::format("arkmesh: bus {}: lab roark uses this LCM port as well; give each lab its own port in bus.url\n",
                  url(roark_port));
  SUBCASE("its lab process") {
    hal::Bus bus(url(roark_port));
    lab_status_t status{};
    status.lab = "roark";
    Process shark = files.start(files.shark, "shark", {"bus.url=\"" + url(roark_port) + "\""});
    REQUIRE(eventually(300s, [&] {
      bus.publish("status", status);
      return shark.wait(100ms).has_value();
    }));
    CHECK(shark.wait(0ms) == 2);
    CHECK(shark.output().ends_with(sentence));
  }
  SUBCASE("its gateway") {
    Process roark = files.start(files.roark, "roark");
    REQUIRE(says(roark, "connecting"));
    Process shark = files.start(files.shark, "shark", {"bus.url=\"" + url(roark_port) + "\""});
    CHECK(shark.wait(300s) == 2);
    // It may have said by then that it listens.
    CHECK(shark.output().ends_with(sentence));
    CHECK(roark.running());
  }
}

// A link of another scheme. While it is made, an earlier gateway of the lab answers on the bus, and a stranger comes to
// the gateway's port: both are there before it can look around, however busy the machine is.
struct Eager final : gateway::Link {
  static inline boost::asio::io_context io;
  static inline std::unique_ptr<RawPeer> stranger;
  static inline bool started = false;
  const std::string name = "lynx";

  const std::string& peer() const override { return name; }
  void start(Events) override { started = true; }
  void offer(const gateway::Rule&, std::string_view, std::span<const std::byte>) override {}
  void keep_only(const Passes&) override {}
  gateway::LinkStats stats() const override { return {}; }
  void stop() override {}

  static std::unique_ptr<gateway::Link> make(const gateway::LinkSurroundings&, const std::string&, std::string_view) {
    stranger = std::make_unique<RawPeer>(io, free_port);
    gateway::Hello hello;
    hello.lab = "roark";
    hello.boot_id = 1;
    hello.max_message_bytes = 1 << 20;
    stranger->say(hello);
    peers_t answer;
    answer.lab = "shark";
    answer.boot_id = 1;
    answer.n_peers = answer.n_counters = 0;
    hal::Bus(url(shark_port)).publish(hal::channel::peers, answer);
    return std::make_unique<Eager>();
  }
};

TEST_CASE("a newcomer that gives way has met nobody") {
  // Although its port is free and its peer is waiting there: a gateway that is not alone starts no link, of whatever
  // scheme, and says not even hello.
  gateway::link_kinds().push_back({"eager", [](std::string_view) { return std::string(); }, Eager::make});
  const std::string text = fmt::format(
      "lab.name = \"shark\"\nbus.url = \"{}\"\nshared.labs = [\"lynx\", \"roark\", \"shark\"]\n[gateway]\n"
      "listen = \"127.0.0.1:{}\"\npeers = [{{lab = \"roark\"}}, {{lab = \"lynx\", connect = \"eager://\"}}]\n",
      url(shark_port), free_port);
  CHECK_THROWS_WITH_AS(
      gateway::run_gateway([&] { return hal::Config::from_text(text, "newcomer.toml"); }),
      fmt::format("bus {}: another gateway of lab shark runs already; stop it first", url(shark_port)).c_str(),
      hal::ConfigError);
  gateway::link_kinds().pop_back();
  REQUIRE(Eager::stranger);
  CHECK_FALSE(Eager::started);
  Eager::stranger->listen();
  Eager::io.run_for(300s);
  CHECK(Eager::stranger->closed);
  CHECK_FALSE(Eager::stranger->hello);
  Eager::stranger.reset();
}

TEST_CASE("a port in use is named") {
  // A TCP port that another program holds ends the gateway with 1 and one sentence.
  const Files files;
  boost::asio::io_context io;
  boost::asio::ip::tcp::acceptor taken(io, {boost::asio::ip::address_v4::loopback(), free_port});
  Process shark = files.start(files.shark, "shark", {fmt::format("gateway.listen=\"127.0.0.1:{}\"", free_port)});
  CHECK(shark.wait(300s) == 1);
  CHECK(
      shark.output() ==
      fmt::format("arkmesh: TCP port {} of 127.0.0.1 is in use by another program; stop it (ss -ltnp shows it) or give "
                  "gateway.listen another port\n",
                  free_port));
}

TEST_CASE("wrong configurations end with one sentence") {
  // Each ends with 2 and names the place; keys of the lab's own tables are none of the gateway's business.
  const std::pair<std::string, std::string> table[] = {
      {"gateway.listen=\"0.0.0.0:7846\"", "gateway.listen = \"0.0.0.0:7846\": is not on this machine"},
      {"gateway.lisen=\"127.0.0.1:1\"", "unknown key 'gateway.lisen'; did you mean 'gateway.listen'?"},
      {"shared.experiment=\"red\\u001b[31m\"", "must be 1 to 63 printable characters"},
      {"lab.name=lynx", "shared.labs = [ \"roark\", \"shark\" ]: does not name this lab, 'lynx'"},
      {"lab.name=\"Not a name\"", "lab.name = \"Not a name\": must be 1 to 15 of the characters a-z 0-9 _ -"},
      {"bus.url=memq://", "bus.url = \"memq://\": must be udpm://ADDRESS:PORT?ttl=0"},
      {"shared.labs=[\"lynx\", \"roark\", \"shark\"]", "has no entry for lab lynx, which shared.labs names; add one"},
  };
  for (const auto& row : table) {
    const auto& [set, sentence] = row;
    CAPTURE(row.first);
    const Files files;
    Process shark = files.start(files.shark, "shark", {set});
    CHECK(shark.wait(300s) == 2);
    const std::string said = shark.output();
    CAPTURE(said);
    CHECK(said.starts_with("arkmesh: "));
    CHECK(said.find(sentence) != std::string::npos);
    CHECK(std::count(said.begin(), said.end(), '\n') == 1);
  }
}

TEST_CASE("SIGTERM ends a gateway at once, also with a stalled peer") {
  // A peer that reads nothing, with a full outbox, does not keep it from ending; no line is printed per
  // message.
  const Files files;
  Process shark = files.start(files.shark, "shark");
  REQUIRE(says(shark, "listening"));
  boost::asio::io_context io;
  RawPeer roark(io, shark_port);
  gateway::Hello hello;
  hello.lab = "roark";
  hello.boot_id = 1;
  hello.max_message_bytes = 1 << 20;
  hello.channels = {gateway::exported("world")};
  roark.say(hello);
  roark.beat();
  REQUIRE(says(shark, "roark connected"));
  hal::Bus bus(url(shark_port));
  peers_t peers;
  const auto subscription = bus.subscribe("peers", [&](std::string_view, auto bytes) { hal::decode(bytes, peers); });
  // Until messages are replaced because the kernel takes no more.
  REQUIRE(eventually(300s, [&] {
    for (int i = 0; i < 20; ++i) bus.publish("world", std::vector<std::byte>(50'000));
    roark.beat();
    bus.drain(20ms);
    if (!peers.peers.empty())
      for (const counter_t& counter : peers.peers[0].counters)
        if (counter.name == "outbox.replaced.world" && counter.value > 100) return true;
    return false;
  }));
  shark.signal(SIGTERM);
  CHECK(shark.wait(300s) == 0);
  const std::string output = shark.output();
  CHECK(std::count(output.begin(), output.end(), '\n') <= 4);
}

}  // namespace
