// `arkmesh doctor` as a user sees it: the real program, on machines that lack one thing each. Network namespaces, empty
// paths and other labs on the same port stand for those machines.
#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_answer_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/bus/bus.hpp"
#include "lab/operator/operator_message.hpp"

namespace {

using namespace arkmesh;
namespace fs = std::filesystem;

// A command that runs beside the test.
class Command {
 public:
  explicit Command(const std::string& line) : pipe_(::popen((line + " 2>&1").c_str(), "r")) {}
  ~Command() {
    if (pipe_) ::pclose(pipe_);
  }
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  // Reads everything it says until it ends; calls `meanwhile` again and again until then.
  std::string words(const std::function<void()>& meanwhile = [] {}) {
    std::string all;
    std::array<char, 4096> piece;
    for (pollfd said{::fileno(pipe_), POLLIN, 0};;) {
      meanwhile();
      if (::poll(&said, 1, 20) == 0) continue;
      const auto n = ::read(said.fd, piece.data(), piece.size());
      if (n <= 0) break;
      all.append(piece.data(), static_cast<std::size_t>(n));
    }
    code_ = WEXITSTATUS(::pclose(std::exchange(pipe_, nullptr)));
    return all;
  }
  int code() const { return code_; }

 private:
  FILE* pipe_;
  int code_ = -1;
};

const std::string doctor = fmt::format("'{}' doctor", ARKMESH_PROGRAM);

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// The line of `words` that speaks of `what`.
std::string line_of(const std::string& words, const std::string& what) {
  const auto at = words.find(what);
  if (at == std::string::npos) return {};
  const auto begin = words.rfind('\n', at) + 1;
  return words.substr(begin, words.find('\n', at) - begin);
}

// A lab's file in a folder of its own that goes with it.
class LabFile {
 public:
  explicit LabFile(const std::string& text) {
    std::string name = (fs::temp_directory_path() / "doctor-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    std::ofstream(path()) << text;
  }
  ~LabFile() { fs::remove_all(folder_); }
  std::string path() const { return folder_ / "lab.toml"; }

 private:
  fs::path folder_;
};

std::string lab_text(int lcm_port, const std::string& listen) {
  return fmt::format(
      "[lab]\nname = \"shark\"\n[bus]\nurl = \"udpm://239.255.76.67:{}?ttl=0\"\n[gateway]\nlisten = \"{}\"\n", lcm_port,
      listen);
}

// A TCP socket that listens on a port that the kernel chose.
class TcpListener {
 public:
  TcpListener() {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof a;
    REQUIRE(::bind(fd_, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0);
    REQUIRE(::listen(fd_, 1) == 0);
    REQUIRE(::getsockname(fd_, reinterpret_cast<sockaddr*>(&a), &length) == 0);
    port_ = ntohs(a.sin_port);
  }
  ~TcpListener() { ::close(fd_); }
  int port() const { return port_; }

 private:
  int fd_ = ::socket(AF_INET, SOCK_STREAM, 0);
  int port_ = 0;
};

}  // namespace

TEST_CASE("no multicast route") {
  // Without a multicast route the doctor says so with a command, and that very command mends it.
  const std::string inside = "unshare --net --map-root-user ";
  if (std::system((inside + "true").c_str()) != 0) {
    MESSAGE("network namespaces are not permitted here, so this case could not be run");
    return;
  }
  Command bare(inside + doctor);
  const std::string line = line_of(bare.words(), "multicast");
  CHECK(bare.code() == 1);
  CHECK(has(line, "problem  multicast on this machine: there is no multicast route"));
  const std::string command = line.substr(line.find("as root: ") + 9);
  CHECK(command == "ip link set lo up; ip route add 224.0.0.0/4 dev lo");

  Command mended(inside + "sh -c \"" + command + "; " + doctor + "\"");
  CHECK(line_of(mended.words(), "multicast") == "ok       multicast on this machine");
}

TEST_CASE("small receive buffer, little disk space") {
  // A kernel that allows too small a receive buffer is told with the command that raises it; a disk that is nearly full
  // with what to do.
  const std::string inside = "unshare --mount --map-root-user ";
  if (std::system((inside + "true").c_str()) != 0) {
    MESSAGE("mount namespaces are not permitted here, so this case could not be run");
    return;
  }
  const LabFile limit("212992\n");  // stands in for the kernel's file; 212992 is Debian's default
  Command small(inside + "sh -c \"mount --bind " + limit.path() +
                " /proc/sys/net/core/rmem_max; mount -t tmpfs -o size=9m none /mnt; cd /mnt; " + doctor + "\"");
  const std::string words = small.words();
  CHECK(small.code() == 1);
  const std::string buffer = line_of(words, "net.core.rmem_max)");
  CHECK(has(buffer, "problem  receive buffer (net.core.rmem_max): the kernel allows 212992 bytes"));
  CHECK(has(buffer, "-> as root: sysctl -w net.core.rmem_max=4194304"));
  CHECK(has(line_of(words, "free disk"), "problem  free disk space: /mnt has 9 MB left"));
}

TEST_CASE("missing programs") {
  // A machine without compiler and LCM tools gets one line for each, naming the package, and the exit code 1.
  Command poor("env PATH=/nonexistent " + doctor);
  const std::string words = poor.words();
  CHECK(poor.code() == 1);
  CHECK(line_of(words, "problem  cc") ==
        "problem  cc: the program cc is missing: it compiles robot controllers when a run begins -> apt-get install "
        "gcc libc6-dev");
  CHECK(has(line_of(words, "problem  lcm-logger"), "apt-get install liblcm-bin"));
  CHECK(has(line_of(words, "problem  Java for lcm-spy"), "apt-get install default-jdk liblcm-java libjchart2d-java"));
  CHECK(has(words, " problems.\n"));
}

TEST_CASE("another lab on our LCM port") {
  // A neighbour on our LCM port is named; junk, our own lab and one that talks to another multicast group are not.
  const LabFile file(lab_text(7870, ""));
  hal::Bus same("udpm://239.255.76.67:7870?ttl=0"), other_group("udpm://239.255.76.68:7870?ttl=0");
  lab_status_t neighbour{}, ours{};
  neighbour.lab = "lynx";
  ours.lab = "shark";
  peers_t far_neighbour{};
  far_neighbour.lab = "roark";
  const std::array<std::byte, 40> junk{};
  Command examined(doctor + " " + file.path());
  const std::string words = examined.words([&] {
    same.publish("status", neighbour);
    same.publish("status", ours);
    same.publish("status", std::span<const std::byte>(junk));
    other_group.publish("peers", far_neighbour);
    same.drain();
    other_group.drain();
  });
  CHECK(examined.code() == 1);
  CHECK(has(words,
            "problem  LCM port of lab shark: lynx: also on udpm://239.255.76.67:7870?ttl=0 -> give "
            "each lab"));
}

TEST_CASE("only our own lab on our LCM port") {
  // A lab that is running already is no problem of its own port, nor is its gateway's listening socket.
  const TcpListener gateway;
  const LabFile file(lab_text(7871, fmt::format("127.0.0.1:{}", gateway.port())));
  hal::Bus bus("udpm://239.255.76.67:7871?ttl=0");
  peers_t ours{};
  ours.lab = "shark";
  Command examined(doctor + " " + file.path());
  const std::string words = examined.words([&] {
    bus.publish("peers", ours);
    bus.drain();
  });
  CHECK(has(words, "ok       LCM port of lab shark\n"));
  CHECK(has(words, "(in use by this lab's own gateway)"));
}

TEST_CASE("labs that STOP of all labs does not reach") {
  // Of four others one obeys and answers, one does not obey, one is not reached, and one is not heard.
  const std::string text = lab_text(7873, "") + "%s[shared]\nlabs = [\"shark\", \"a\", \"b\", \"c\", \"d\"]\n";
  const auto file_with = [&](const std::string& key) {
    return LabFile(std::string(text).replace(text.find("%s"), 2, key));
  };
  const LabFile file = file_with("ordered = [\"operator_command\"]\n"), mute = file_with(""),
                loose = file_with("exports = [\"status\", \"operator_command\"]\n[safety]\ncommands_from = [\"b\"]\n");
  hal::Bus bus("udpm://239.255.76.67:7873?ttl=0");
  const auto answers = bus.subscribe(lab::operator_channel, [&](std::string_view, auto) {
    for (const char* lab : {"a", "b"}) bus.publish(std::string(lab) + "/operator_answer", operator_answer_t{});
  });
  const auto speak = [&] {
    for (const char* lab : {"a", "b", "c"}) {
      lab_status_t status{};
      status.lab = lab;
      if (status.lab != "b") status.obeys = {"roark", "shark"};
      status.n_obeys = static_cast<std::int32_t>(status.obeys.size());
      bus.publish(status.lab + "/status", status);
    }
    bus.drain();
  };
  Command examined(doctor + " " + file.path());
  CHECK(line_of(examined.words(speak), "STOP of all labs") ==
        "problem  STOP of all labs (unknown for labs that are not heard: d): b does not accept commands from shark's "
        "operator: safety.commands_from in the file of b does not name shark; c does not answer this lab's operator; "
        "does this "
        "lab's gateway export operator_command, and does that of c import it? -> docs/security.md, Operators of other "
        "labs, "
        "explains what each file needs");
  Command mute_lab(doctor + " " + mute.path());
  CHECK(has(line_of(mute_lab.words(), "STOP of all labs"),
            ": no rule exports operator_command to a, b, c, d, so no operator of shark is heard there; name it in "
            "gateway.ordered -> docs/"));
  Command loose_lab(doctor + " " + loose.path());
  CHECK(has(
      line_of(loose_lab.words(), "STOP of all labs"),
      ": operator_command or operator_answer is not \"ordered\" for a, b, c, d, so a newer message can replace a "
      "command or its answer; name operator_command in gateway.ordered only; no rule imports operator_command from b, "
      "so shark does not hear their STOP; name it in gateway.imports -> docs/"));
}

TEST_CASE("TCP port taken") {
  // A listening port that another program has is named with the way to find out whose it is; a free one is fine.
  const TcpListener other;
  const std::string taken = fmt::format("127.0.0.1:{}", other.port());
  const LabFile file(lab_text(7872, taken));
  Command examined(doctor + " " + file.path());
  CHECK(has(
      examined.words(),
      fmt::format("problem  TCP {}: port {} is taken by another program -> list its user with: ss -ltnp 'sport = :{}'",
                  taken, other.port(), other.port())));
  CHECK(examined.code() == 1);

  std::string free;
  {
    const TcpListener gone;
    free = fmt::format("127.0.0.1:{}", gone.port());
  }
  const LabFile fine(lab_text(7872, free));
  Command second(doctor + " " + fine.path());
  CHECK(has(second.words(), fmt::format("ok       TCP {}\n", free)));
}

TEST_CASE("addresses to listen on are those that the gateway takes") {
  // Each name of this machine and a port of the system's choice are fine; an address for everybody is not.
  const auto finding = [](const std::string& listen) {
    const LabFile file(lab_text(7872, listen));
    Command examined(doctor + " " + file.path());
    return line_of(examined.words(), "TCP " + listen);
  };
  CHECK(finding("localhost:0") == "ok       TCP localhost:0");
  CHECK(finding("[::1]:0") == "ok       TCP [::1]:0");
  CHECK(has(finding("0.0.0.0:0"), "problem  TCP 0.0.0.0:0: gateway.listen is not on this machine"));
  CHECK(has(finding("7801"), "problem  TCP 7801: gateway.listen must be HOST:PORT"));
}

TEST_CASE("a lab file that is wrong") {
  // A wrong file ends the doctor with one sentence that names the file, not with a crash.
  const LabFile file("[lab]\nname = 3\n");
  Command examined(doctor + " " + file.path());
  CHECK(has(examined.words(), "lab.toml:2: lab.name"));
  CHECK(examined.code() != 0);
}

TEST_CASE("a testbed whose controller and camera are not there") {
  // The doctor tries what a lab with a real testbed names: one line for each that is missing, with the reason; in
  // simulation it does not ask.
  const std::string table =
      lab_text(7873, "") +
      "[arena]\nuse = \"kilobot\"\n[arena.kilobot]\nport = \"tcp://127.0.0.1:1\"\n[[arena.kilobot.cameras]]\n"
      "source = \"/dev/video987\"\ncalibration = \"none.yaml\"\n";
  const LabFile file(table);
  Command examined(doctor + " " + file.path());
  const std::string words = examined.words();
  CAPTURE(words);
  CHECK(examined.code() == 1);
  CHECK(has(line_of(words, "overhead controller tcp://127.0.0.1:1"), "Connection refused"));
  CHECK(has(line_of(words, "problem  camera /dev/video987"), "there is no camera /dev/video987; is it plugged in?"));
  Command simulated(doctor + " " + file.path() + " --set arena.use=ode");
  CHECK(!has(simulated.words(), "overhead controller"));
}
