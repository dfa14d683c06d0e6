// An operator in another terminal: stop, pause and resume, and labs that are started and ended together.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/labs/lab_processes.hpp"

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
    return tests::eventually(30s, [&] { return up->output().find(words) != std::string::npos || !up->running(); }) &&
           up->output().find(words) != std::string::npos;
  }
  tests::TemporaryFolder folder;
  std::unique_ptr<tests::Process> up;
};

// Whether a process has this word in its command line.
bool somebody_has(const std::string& word) {
  for (const auto& process : fs::directory_iterator("/proc"))
    if (tests::read_file(process.path() / "cmdline").find(word) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST_CASE("stop, pause and resume reach a lab from another terminal") {
  tests::LabProcesses labs({.labs = {"shark"}, .overrides = {"arena.use=null", "arena.pace=1.0", "gate.period_s=0.5"}});
  labs.start();
  REQUIRE(labs.reached("shark", 1, 20s));
  const tests::TemporaryFolder folder;
  auto tell = [&, told = 0](const std::string& word, int code) mutable {
    tests::Process process(ARKMESH_PROGRAM, {word, shark_lab, "--set", "bus.url=\"" + labs.bus_url("shark") + "\""},
                           folder.path() / fmt::format("said-{}.txt", ++told));
    CHECK(process.wait(20s) == code);
    return process.output();
  };
  CHECK(tell("pause", 0).starts_with("shark paused its robots at period"));
  CHECK(tell("resume", 0).starts_with("shark lets its robots go on from period"));
  CHECK(tell("stop", 0).starts_with("shark ended at period"));
  CHECK(labs.lab("shark").wait(10s) == 3);
  CHECK(labs.result("shark", "state") == "stopped");
  CHECK(tell("stop", 1).find("no lab speaks on") != std::string::npos);
}

TEST_CASE("up runs labs and gateways as one, and Ctrl-C ends them all with their results") {
  UpBench bench;
  REQUIRE(bench.says("a: a  period"));
  REQUIRE(bench.says("b: b  period"));
  bench.up->signal(SIGINT);
  CHECK(bench.up->wait(20s) == 3);
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
           json["lab"]["counters"].contains("world.counted") && json["gateway"]["peers"]["b"]["clock"].is_object();
  }));
  CHECK(json["lab"]["name"] == "a");
  // Both on one machine.
  CHECK(std::abs(json["gateway"]["peers"]["b"]["clock"]["offset_s"].get<double>()) <
        json["gateway"]["peers"]["b"]["clock"]["uncertainty_s"].get<double>() + 1e-3);
  CHECK(json["gateway"]["peers"]["b"]["channels"].contains("b/world"));
  CHECK(json["gateway"]["peers"]["b"]["newest_age_s"] < 300);
  const std::string text = status({bench.file("a")}, 0);
  CHECK(text.find("lab a: ") == 0);
  CHECK(text.find("\n  b         up ") != std::string::npos);
  CHECK(status({bench.file("a"), "--set", "bus.url=\"udpm://239.255.76.67:7973?ttl=0\""}, 1)
            .find("neither a lab nor a gateway speaks on") != std::string::npos);
  bench.up->signal(SIGINT);
  CHECK(bench.up->wait(300s) == 3);
}

TEST_CASE("up ends with the labs, also with those that another terminal stopped") {
  UpBench bench;
  REQUIRE(bench.says("a: a  period"));
  tests::Process stop(ARKMESH_PROGRAM, {"stop", bench.file("b")}, bench.folder.path() / "stop.txt");
  CHECK(stop.wait(20s) == 0);
  CHECK(bench.up->wait(30s).value_or(-1) > 0);
  CHECK(bench.up->output().find("lab b has ended with code 3") != std::string::npos);
  CHECK(bench.state("b") == "stopped");
  CHECK(bench.state("a") != "running");
  CHECK(bench.state("a") != "finished");
}

TEST_CASE("up leaves nobody behind when it is killed") {
  UpBench bench;
  REQUIRE(bench.says("a: a  period"));
  bench.up->kill();
  CHECK(tests::eventually(20s, [&] { return !somebody_has(bench.file("a")) && !somebody_has(bench.file("b")); }));
  CHECK(bench.state("a") == "stopped");
}

TEST_CASE("up ends the others when a lab is refused") {
  UpBench bench("arena.nonsense=1");
  CHECK(bench.up->wait(30s) == 2);
  CHECK(bench.up->output().find("a: arkmesh: --set arena.nonsense") != std::string::npos);
  CHECK_FALSE(somebody_has(bench.folder.path().string()));
}
