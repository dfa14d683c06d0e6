// An operator in another terminal: stop, pause and resume, and labs that are started and ended together.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "arkmesh/fleet_command_t.hpp"
#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "hal/bus/bus.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/network/test_keys.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

const std::string shark_lab = ARKMESH_SOURCE_DIR "/experiments/dhtf/shark.toml";

// Two small labs that reach each other, in a folder of their own, and `arkmesh up` of both.
struct UpBench {
  explicit UpBench(const std::string& more = "") {
    for (int i = 0; i < 2; ++i) {
      const std::string name = i == 0 ? "a" : "b",
                        peer = i == 0 ? "{lab = \"b\"}" : "{lab = \"a\", connect = \"127.0.0.1:7971\"}";
      std::ofstream(folder.path() / (name + ".toml")) << fmt::format(
          "[lab]\nname = \"{}\"\n[run]\nscenario = \"dhtf\"\nduration_s = 100\n[scenario.dhtf.requirements]\na "
          "= [1, 2]\nb = [1, 2]\n[bus]\nurl = \"udpm://239.255.76.67:{}?ttl=0\"\n[shared]\nlabs = [\"a\", "
          "\"b\"]\n[gateway]\nlisten = \"127.0.0.1:{}\"\npeers = [{}]\n[arena]\nuse = \"null\"\npace = 1.0\n",
          name, 7971 + i, 7971 + i, peer);
    }
    std::vector<std::string> words = {"up", file("a"), file("b"), "--out", (folder.path() / "out").string()};
    if (!more.empty()) words.insert(words.end(), {"--set", more});
    up = std::make_unique<tests::Process>(ARKMESH_PROGRAM, words, folder.path() / "said.txt");
  }
  std::string file(const std::string& lab) const { return (folder.path() / (lab + ".toml")).string(); }
  std::string state(const std::string& lab) const {
    const auto json =
        nlohmann::json::parse(tests::read_file(folder.path() / "out" / lab / "result.json"), nullptr, false);
    return json.is_object() ? json.value("state", "") : "";
  }
  bool says(const std::string& words) {
    return tests::eventually(300s, [&] { return up->output().find(words) != std::string::npos || !up->running(); }) &&
           up->output().find(words) != std::string::npos;
  }
  tests::TemporaryFolder folder;
  std::unique_ptr<tests::Process> up;
};

// Of the lab that runs this file; 0 when none does.
pid_t lab_process(const std::string& file) {
  for (const auto& process : fs::directory_iterator("/proc")) {
    const std::string words = tests::read_file(process.path() / "cmdline");
    if (words.find(std::string("lab") + '\0' + file) != std::string::npos)
      return std::stoi(process.path().filename().string());
  }
  return 0;
}

// Whether a process has this word in its command line.
bool somebody_has(const std::string& word) {
  for (const auto& process : fs::directory_iterator("/proc"))
    if (tests::read_file(process.path() / "cmdline").find(word) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST_CASE("a lab that ends because another one of its group was killed says so") {
  UpBench bench;
  REQUIRE(bench.says("period 1"));
  const pid_t a = lab_process(bench.file("a"));
  REQUIRE(a > 0);
  ::kill(a, SIGKILL);
  CHECK(bench.up->wait(300s) == 1);
  CHECK(bench.state("b") == "failed");
  const auto result = nlohmann::json::parse(tests::read_file(bench.folder.path() / "out/b/result.json"));
  CHECK(result.at("ended") == "another process of the same arkmesh up has ended");
}

TEST_CASE("stop, pause, resume and reset reach a lab from another terminal") {
  tests::LabProcesses labs({.labs = {"shark"}, .overrides = {"arena.use=null", "arena.pace=1.0", "gate.period_s=0.5"}});
  labs.start();
  REQUIRE(labs.reached("shark", 1, 300s));
  const tests::TemporaryFolder folder;
  auto tell = [&, told = 0](const std::string& word, int code) mutable {
    tests::Process process(ARKMESH_PROGRAM, {word, shark_lab, "--set", "bus.url=\"" + labs.bus_url("shark") + "\""},
                           folder.path() / fmt::format("said-{}.txt", ++told));
    CHECK(process.wait(300s) == code);
    return process.output();
  };
  CHECK(tell("pause", 0).starts_with("shark paused its robots at period"));
  CHECK(tell("resume", 0).starts_with("shark resumed its robots at period"));
  CHECK(tell("reset", 0).starts_with("shark reset its robots, which wait for resume, at period"));
  // Who cannot read the user's key is refused, in one sentence of the lab.
  const char* const before = std::getenv("XDG_CONFIG_HOME");
  const std::string home = before ? before : "";
  ::setenv("XDG_CONFIG_HOME", folder.path().c_str(), 1);
  CHECK(tell("pause", 1).find("shark refused the command: bad_proof") != std::string::npos);
  before ? ::setenv("XDG_CONFIG_HOME", home.c_str(), 1) : ::unsetenv("XDG_CONFIG_HOME");
  CHECK(labs.lab_output("shark").find("is not authenticated with this user's key") != std::string::npos);
  CHECK(tell("stop", 0).starts_with("shark ended at period"));
  CHECK(labs.lab("shark").wait(300s) == 3);
  CHECK(labs.result("shark", "state") == "stopped");
  CHECK(tell("stop", 1).find("no lab is heard on") != std::string::npos);
}

TEST_CASE("a lab does not obey who cannot prove to be its operator, and its hash does not change") {
  // Every program of this machine may publish on the lab's bus. What it sends is refused, counted, said once, and not
  // recorded; the operator's own word, heard and sent again, does nothing; and the operator is obeyed all the same.
  const auto start = [](tests::LabProcesses& labs) {
    labs.start_lab("shark");
    return labs.reached("shark", 1, 300s);
  };
  const tests::LabProcesses::Options alone{.labs = {"shark"}, .overrides = {"run.duration_s=400", "arena.robots=3"}};
  tests::LabProcesses undisturbed(alone), labs(alone);
  REQUIRE(start(undisturbed));
  CHECK(undisturbed.lab("shark").wait(300s) == 0);
  REQUIRE(start(labs));
  hal::Bus stranger(labs.bus_url("shark"));
  operator_command_t forged{};
  forged.lab = "shark";
  const auto status = stranger.subscribe("status", [&](std::string_view, auto bytes) {
    if (lab_status_t m; hal::decode(bytes, m)) forged.run_id = m.nonce;
  });
  REQUIRE(tests::eventually(300s, [&] { return stranger.drain(20ms), forged.run_id != 0; }));
  fleet_command_t unproved{};
  unproved.command = forged.command.command = fleet_command_t::pause;
  for (int i = 0; i < 3000; ++i) {
    stranger.publish("operator_command", unproved);
    stranger.publish("operator_command", forged);
    forged.number = i;
    if (i % 100 == 0) std::this_thread::sleep_for(1ms);
  }
  CHECK(labs.lab("shark").wait(300s) == 0);
  CHECK(labs.result("shark", "final_hash") == undisturbed.result("shark", "final_hash"));
  const auto counters = nlohmann::json::parse(labs.result("shark", "counters"));
  CHECK(counters.value("operator.refused.undecodable", 0) > 0);
  CHECK(counters.value("operator.refused.bad_proof", 0) + counters.value("operator.refused.no_key", 0) > 0);
  CHECK_FALSE(counters.contains("operator.commands"));
  const std::string said = labs.lab_output("shark");
  CHECK(said.find("shark refused a command on operator_command: ") != std::string::npos);
  CHECK(std::count(said.begin(), said.end(), '\n') < 50);
  CHECK(tests::read_file(labs.directory("shark") / "log.lcm").find("operator_command") == std::string::npos);
}

TEST_CASE("an operator pauses another lab that names it, and resumes it while it is armed") {
  // Over the gateways, by the key of the own lab; what the other lab's own operator does disarms it.
  const tests::TestKeys keys;
  keys.join("shark", "roark");
  const auto keys_of = [&](const std::string& lab) { return "gateway.keys=\"" + keys.of(lab).path().string() + "\""; };
  tests::LabProcesses labs(
      {.overrides = {"arena.use=null", "arena.pace=1.0", "gate.period_s=0.5", "gateway.ordered=[\"operator_command\"]"},
       .by_lab = {{"shark",
                   {keys_of("shark"), "safety.commands_from=[\"roark\"]",
                    "gateway.imports=[\"world\",\"status\",\"operator_command\"]"}},
                  {"roark", {keys_of("roark"), "safety.commands_from=[]"}}}});
  labs.start();
  REQUIRE(labs.reached("shark", 1, 300s));
  const tests::TemporaryFolder folder;
  auto tell = [&, told = 0](std::vector<std::string> words, const std::string& lab, int code) mutable {
    words.insert(words.end(), {ARKMESH_SOURCE_DIR "/experiments/dhtf/" + lab + ".toml", "--set",
                               "bus.url=\"" + labs.bus_url(lab) + "\"", "--set", keys_of(lab)});
    tests::Process process(ARKMESH_PROGRAM, words, folder.path() / fmt::format("said-{}.txt", ++told));
    CHECK(process.wait(300s) == code);
    return process.output();
  };
  CHECK(tell({"pause", "--at", "shark"}, "roark", 0).starts_with("shark paused its robots at period"));
  CHECK(tell({"resume", "--at", "shark"}, "roark", 1).find("shark refused the command: not_armed") !=
        std::string::npos);
  CHECK(tell({"arm"}, "shark", 0).find(", armed") != std::string::npos);
  CHECK(tell({"status"}, "shark", 0).find(", armed") != std::string::npos);
  CHECK(tell({"resume", "--at", "shark"}, "roark", 0).starts_with("shark resumed its robots at period"));
  const std::string world = tell({"pause", "--world"}, "roark", 0);
  CHECK(world.find("roark paused its robots at period") != std::string::npos);
  CHECK(world.find("shark paused its robots at period") != std::string::npos);
  CHECK(tell({"resume", "--world"}, "roark", 0).find("shark resumed its robots") != std::string::npos);
  CHECK(tell({"pause", "--world"}, "shark", 1).find("roark") != std::string::npos);  // which does not name shark
  CHECK(tell({"pause"}, "shark", 0).find("armed") == std::string::npos);
  CHECK(tell({"resume", "--at", "shark"}, "roark", 1).find("shark refused the command: not_armed") !=
        std::string::npos);
  CHECK(tell({"stop"}, "shark", 0).starts_with("shark ended at period"));
  CHECK(labs.lab("shark").wait(300s) == 3);
  const auto counters = nlohmann::json::parse(labs.result("shark", "counters"));
  CHECK(counters.at("operator.commands.roark") == 4);
  CHECK(counters.at("operator.refused.not_armed") == 2);
  const std::string audit = tests::read_file(labs.directory("shark") / "audit.csv");
  CHECK(audit.find(",roark,resume,not_armed\n") != std::string::npos);
  CHECK(audit.find(",roark,pause,admitted\n") != std::string::npos);
}

TEST_CASE("up runs labs and gateways as one, and Ctrl-C ends them all with their results") {
  UpBench bench;
  REQUIRE(bench.says("a: a  period"));
  REQUIRE(bench.says("b: b  period"));
  bench.up->signal(SIGINT);
  CHECK(bench.up->wait(300s) == 3);
  CHECK(bench.state("a") == "stopped");
  CHECK_FALSE(somebody_has(bench.folder.path().string()));
}

TEST_CASE("status tells how a lab and its links are") {
  UpBench bench;
  int told = 0;
  const auto status = [&](std::vector<std::string> words, int code) {
    words.insert(words.begin(), "status");
    tests::Process process(ARKMESH_PROGRAM, words, bench.folder.path() / fmt::format("status{}.txt", ++told));
    CHECK(process.wait(300s) == code);
    return process.output();
  };
  REQUIRE(bench.says("a: a  period"));
  nlohmann::json json;
  CHECK(tests::eventually(300s, [&] {
    json = nlohmann::json::parse(status({bench.file("a"), "--json"}, 0));
    return json["gateway"].is_object() && json["gateway"]["peers"]["b"]["up"] == true &&
           json["gateway"]["peers"]["b"]["per_s"]["received.messages"].is_number() && json["lab"].is_object() &&
           json["gateway"]["peers"]["b"]["settings"].is_string() && json["lab"]["counters"].contains("world.counted") &&
           json["gateway"]["peers"]["b"]["clock"].is_object();
  }));
  CHECK(json["lab"]["name"] == "a");
  CHECK(json["lab"]["settings"].get<std::string>().size() == 16);
  CHECK(json["gateway"]["peers"]["b"]["settings"] == json["lab"]["settings"]);
  // Both on one machine.
  CHECK(std::abs(json["gateway"]["peers"]["b"]["clock"]["offset_s"].get<double>()) <
        json["gateway"]["peers"]["b"]["clock"]["uncertainty_s"].get<double>() + 1e-3);
  CHECK(json["gateway"]["peers"]["b"]["channels"].contains("b/world"));
  CHECK(json["gateway"]["peers"]["b"]["newest_age_s"] < 300);
  const std::string text = status({bench.file("a")}, 0);
  CHECK(text.find("lab a: ") == 0);
  CHECK(text.find("\n  b         up ") != std::string::npos);
  CHECK(status({bench.file("a"), "--set", "bus.url=\"udpm://239.255.76.67:7973?ttl=0\""}, 1)
            .find("neither a lab nor a gateway is heard on") != std::string::npos);
  bench.up->signal(SIGINT);
  CHECK(bench.up->wait(300s) == 3);
}

TEST_CASE("up ends with the labs, also with those that another terminal stopped") {
  UpBench bench;
  REQUIRE(bench.says("a: a  period"));
  tests::Process stop(ARKMESH_PROGRAM, {"stop", bench.file("b")}, bench.folder.path() / "stop.txt");
  CHECK(stop.wait(300s) == 0);
  CHECK(bench.up->wait(300s).value_or(-1) > 0);
  CHECK(bench.up->output().find("lab b has ended with code 3") != std::string::npos);
  CHECK(bench.state("b") == "stopped");
  CHECK(bench.state("a") != "running");
  CHECK(bench.state("a") != "finished");
}

TEST_CASE("up leaves nobody behind when it is killed") {
  UpBench bench;
  REQUIRE(bench.says("a: a  period"));
  bench.up->kill();
  CHECK(tests::eventually(300s, [&] { return !somebody_has(bench.file("a")) && !somebody_has(bench.file("b")); }));
  CHECK(bench.state("a") == "stopped");
}

TEST_CASE("up ends the others when a lab is refused") {
  UpBench bench("arena.nonsense=1");
  CHECK(bench.up->wait(300s) == 2);
  CHECK(bench.up->output().find("a: arkmesh: --set arena.nonsense") != std::string::npos);
  CHECK_FALSE(somebody_has(bench.folder.path().string()));
}
