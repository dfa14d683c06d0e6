// `arkmesh ohc` as people start it: what it puts on the line, what it says, and its exit codes.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <csignal>
#include <fstream>
#include <string>
#include <vector>

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

constexpr std::chrono::milliseconds deadline = 300s;

struct Outcome {
  int code = -1;
  std::string output;
  std::vector<Packet> heard;
};

// Runs `arkmesh ohc PORT ARGUMENTS...` to its end, listening at the port.
Outcome say(const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  Listener listener;
  std::vector<std::string> all{"ohc", listener.port(), "--settle", "0"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  Process process(ARKMESH_PROGRAM, all, folder.path() / "output");
  Outcome out;
  PacketEar ear;
  const auto listen = [&] {
    const std::vector<std::uint8_t> bytes = listener.read();
    for (const Packet& packet : ear.hear(bytes)) out.heard.push_back(packet);
    return !bytes.empty();
  };
  CHECK(eventually(deadline, [&] { return listen(), !process.running(); }));
  while (listen()) {
  }
  out.code = process.wait(deadline).value_or(-1);
  out.output = process.output();
  return out;
}

// Without the stops at the beginning and at the end, which are checked.
std::vector<Packet> meant(const Outcome& outcome) {
  CAPTURE(outcome.output);
  CHECK(outcome.code == 0);
  REQUIRE(outcome.heard.size() >= 2);
  CHECK(outcome.heard.front()[1] == 0);
  CHECK(outcome.heard.back()[1] == 0);
  return {outcome.heard.begin() + 1, outcome.heard.end() - 1};
}

Packet forward(std::uint8_t type, std::array<std::uint8_t, 9> data = {}) {
  return forward_packet(Message{data, type, 0});
}

void check_fails(const std::vector<std::string>& arguments, int code, const std::string& says) {
  const TemporaryFolder folder;
  std::vector<std::string> all{"ohc"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  Process process(ARKMESH_PROGRAM, all, folder.path() / "output");
  CHECK(process.wait(deadline) == code);
  const std::string output = process.output();
  CAPTURE(output);
  CAPTURE(says);
  CHECK(output.find(says) != std::string::npos);
}

std::filesystem::path small_program(const TemporaryFolder& folder) {
  const auto file = folder.path() / "robot.hex";
  std::ofstream(file) << ":040000000102030"
                      << "4F2\n:00000001FF\n";
  return file;
}

}  // namespace

TEST_CASE("ohc: commands") {
  // Each command puts its packet on the line between two stops.
  const std::vector<std::pair<std::string, std::uint8_t>> commands{
      {"run", type_run},     {"pause", type_wakeup},    {"reset", type_reset},  {"sleep", type_sleep},
      {"wake", type_wakeup}, {"voltage", type_voltage}, {"charge", type_charge}};
  for (const auto& command : commands) {
    const auto& [name, type] = command;
    CAPTURE(command.first);
    const Outcome outcome = say({name, "--seconds", "0.05"});
    CHECK(meant(outcome) == std::vector{forward(type)});
    CHECK(outcome.heard.back() == stop_packet());
  }
  CHECK(meant(say({"lamp"})) == std::vector{led_toggle_packet()});
  CHECK(meant(say({"stop"})).empty());
}

TEST_CASE("ohc: numbers") {
  // Ids, duties and messages are packed as robots read them.
  const std::vector<std::string> seconds{"--seconds", "0.05"};
  const auto numbers = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), seconds.begin(), seconds.end());
    return meant(say(arguments));
  };
  CHECK(numbers({"set-uid", "300", "--yes"}) ==
        std::vector{forward(type_calibrate, {1, 0x2C, 1}), forward(type_calibrate)});
  CHECK(numbers({"left", "72"}) == std::vector{forward(type_calibrate, {2, 0, 0, 72})});
  CHECK(numbers({"right", "0x4a"}) == std::vector{forward(type_calibrate, {3, 0, 0, 0, 74})});
  CHECK(numbers({"straight", "65", "70"}) == std::vector{forward(type_calibrate, {4, 0, 0, 0, 0, 65, 70})});
  CHECK(numbers({"save"}) == std::vector{forward(type_calibrate)});
  CHECK(numbers({"message", "120", "1", "0xFF", "3"}) == std::vector{forward(120, {1, 255, 3})});
}

TEST_CASE("ohc: a command says what was sent") {
  // One line; robots that go on moving are told of.
  const auto says = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--seconds", "0.05"});
    const std::string output = say(arguments).output;
    return output.substr(output.find(arguments.front()));
  };
  CHECK(says({"run"}) == "run: sent for 0.05 s\n");
  CHECK(says({"set-uid", "3", "--yes"}) == "set-uid: sent for 0.1 s\n");
  const std::string moving =
      ": sent for 0.05 s; robots continue until `pause`, or until `save`, which stores the duties\n";
  CHECK(says({"left", "72"}) == "left" + moving);
  CHECK(says({"straight", "65", "70"}) == "straight" + moving);
}

TEST_CASE("ohc: set-uid asks") {
  // It reaches every robot in sight. At a terminal it asks; without one it wants --yes.
  const TemporaryFolder folder;
  const Listener listener;
  PseudoTerminal terminal;
  const auto start = [&](const std::string& from) {
    return std::make_unique<Process>("/bin/sh",
                                     std::vector<std::string>{"-c", R"(exec "$0" ohc "$1" --settle 0 set-uid 12 <"$2")",
                                                              ARKMESH_PROGRAM, listener.port(), from},
                                     folder.path() / "output");
  };
  const auto alone = start("/dev/null");
  CHECK(alone->wait(deadline) == 2);
  CHECK(
      alone->output().find(
          "--yes: is needed without a terminal, where arkmesh cannot ask: Every robot in range will store the id 12") !=
      std::string::npos);
  for (const auto& [answer, code] : {std::pair{"n\n", 1}, {"y\n", 0}}) {
    const auto asked = start(terminal.link());
    CHECK(eventually(deadline, [&] { return asked->output().find("[y/N]") != std::string::npos; }));
    terminal.say(answer);
    CHECK(asked->wait(deadline) == code);
    CHECK(asked->output().ends_with(code == 0 ? "set-uid: sent for 2 s\n" : "arkmesh: nothing was sent\n"));
  }
}

TEST_CASE("ohc: upload") {
  // A program goes out in rounds after the call to the boot loaders, with progress; it ends by itself after the rounds
  // asked for.
  const TemporaryFolder folder;
  const Outcome outcome = say({"upload", small_program(folder), "--rounds", "2", "--boot", "0.1", "--page-ms", "132"});
  std::array<std::uint8_t, page_bytes> page{1, 2, 3, 4};
  const std::vector<Packet> round{forward(type_boot_size, {1}), boot_page_packet(0, page)};
  CHECK(meant(outcome) == std::vector{forward(type_boot), round[0], round[1], round[0], round[1]});
  CHECK(outcome.output.find("robot.hex: 4 bytes, 1 page") != std::string::npos);
  CHECK(outcome.output.find("2 rounds of 1 page sent") != std::string::npos);
}

TEST_CASE("ohc: stopping an upload") {
  // Ctrl-C ends an upload without end well: with a stop, a summary and code 0.
  const TemporaryFolder folder;
  Listener listener;
  Process process(
      ARKMESH_PROGRAM,
      {"ohc", listener.port(), "--settle", "0", "upload", small_program(folder), "--boot", "0.1", "--page-ms", "132"},
      folder.path() / "output");
  PacketEar ear;
  std::vector<Packet> heard;
  const auto listen = [&] {
    for (const Packet& packet : ear.hear(listener.read())) heard.push_back(packet);
  };
  CHECK(eventually(deadline, [&] { return listen(), heard.size() >= 7; }));
  process.signal(SIGINT);
  CHECK(eventually(deadline, [&] { return listen(), !process.running(); }));
  listen();
  CHECK(process.wait(deadline) == 0);
  CHECK(process.output().find("stopped") != std::string::npos);
  CHECK(heard.back()[1] == static_cast<std::uint8_t>(PacketType::stop));
}

TEST_CASE("ohc: a real serial device") {
  // The program itself, with the library that opens serial devices, talks to a pseudo-terminal; that one goes away on
  // the way.
  std::string preload = ARKMESH_PTY_SHIM;
  // under a sanitizer its library has to come first
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (const auto at = line.find('/'); line.find("libasan") != std::string::npos && at != std::string::npos) {
      preload = line.substr(at) + " " + preload;
      break;
    }
  const TemporaryFolder folder;
  PseudoTerminal terminal;
  const auto start = [&](const std::string& seconds) {
    return std::make_unique<Process>(
        "/usr/bin/env",
        std::vector<std::string>{"LD_PRELOAD=" + preload, ARKMESH_PROGRAM, "ohc", terminal.port(), "run", "--settle",
                                 "0", "--seconds", seconds},
        folder.path() / "output");
  };
  PacketEar ear;
  std::vector<Packet> heard;
  const auto listen = [&] {
    for (const Packet& packet : ear.hear(terminal.read())) heard.push_back(packet);
  };
  auto process = start("0.1");
  CHECK(eventually(deadline, [&] { return listen(), !process->running(); }));
  listen();
  CAPTURE(process->output());
  CHECK(process->wait(deadline) == 0);
  REQUIRE(heard.size() == 3);
  CHECK(heard[1] == forward(type_run));
  CHECK(heard[2] == stop_packet());

  // unplugged while it speaks
  heard.clear();
  process = start("60");
  CHECK(eventually(deadline, [&] { return listen(), heard.size() == 2; }));
  terminal.unplug();
  CHECK(process->wait(deadline) == 1);
  CHECK(process->output().find("was unplugged") != std::string::npos);
}

TEST_CASE("ohc: complaints") {
  // What cannot be done is said in a sentence: 2 for a wrong command line, 1 for what is not there.
  check_fails({}, 2, "PORT");
  check_fails({"tcp://127.0.0.1:9"}, 2, "subcommand");
  check_fails({"tcp://nowhere", "run"}, 2, "write tcp://host:port");
  check_fails({"/dev/ttyNONE7", "run"}, 1, "there is no serial port /dev/ttyNONE7");
  check_fails({"/etc/passwd", "run"}, 1, "is not a serial port");
  check_fails({"tcp://127.0.0.1:1", "jump"}, 2, "arkmesh ohc has no command jump; arkmesh ohc --help lists them");
  check_fails({"tcp://127.0.0.1:9", "message", "128"}, 2, "is reserved for the robots' library");
  check_fails({"tcp://127.0.0.1:9", "message", "12x"}, 2, "'12x' is not a number from 0 to 255");
  check_fails({"tcp://127.0.0.1:9", "message", "1", "0", "0", "0", "0", "0", "0", "0", "0", "0", "0"}, 2,
              "9 bytes, not 10");
  check_fails({"tcp://127.0.0.1:9", "set-uid", "65536"}, 2, "from 0 to 65535");
  check_fails({"tcp://127.0.0.1:9", "left", "-1"}, 2, "");
  check_fails({"tcp://127.0.0.1:9", "run", "--seconds", "0"}, 2, "--seconds");
  check_fails({"tcp://127.0.0.1:9", "upload", "/nowhere/robot.hex"}, 1,
              "/nowhere/robot.hex: cannot be read: No such file");
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "bad.hex") << ":00000001FE\n";
  check_fails({"tcp://127.0.0.1:9", "upload", folder.path() / "bad.hex"}, 1,
              "bad.hex:1: the checksum is FE but should be FF");
  check_fails({"tcp://127.0.0.1:9", "upload", folder.path() / "bad.hex", "--page-ms", "100"}, 2, "--page-ms");
}
