#include <doctest/doctest.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/labs/dhtf_labs.hpp"
#include "tests/support/labs/lab_processes.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

struct Said {
  int code = -1;
  std::string text;
};

// Runs the program to its end and gives what it said.
Said say(const std::vector<std::string>& arguments) {
  const tests::TemporaryFolder folder;
  tests::Process process(ARKMESH_PROGRAM, arguments, folder.path() / "said.txt");
  const auto code = process.wait(300s);
  return {code.value_or(-1), process.output()};
}

std::string lab_file(const char* lab) {
  return (tests::experiments() / "dhtf" / (std::string(lab) + ".toml")).string();
}

// `arkmesh run` of shark alone with one override.
Said run_with(const std::string& set, const std::vector<std::string>& more = {}) {
  const tests::TemporaryFolder folder;
  std::vector<std::string> arguments = {"run",   lab_file("shark"),   "--out", (folder.path() / "out").string(),
                                        "--set", "run.duration_s=20", "--set", set};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return say(arguments);
}

bool one_sentence(const std::string& text) {
  return text.starts_with("arkmesh: ") && text.find('\n') == text.size() - 1;
}

}  // namespace

TEST_CASE("wrong configuration is said in one sentence that names the key, with exit code 2") {
  // Proves that every rule of a lab's configuration fails early and plainly.
  struct Case {
    const char* set;
    std::vector<std::string> expected;
  };
  const std::vector<Case> cases = {
      {"arena.widht_m=1.0", {"arena.widht_m", "did you mean", "arena.width_m"}},
      {"arena.width_cm=100.0", {"arena.width_cm", "arena.width_m"}},
      {"arena.width_m=\"wide\"", {"arena.width_m"}},
      {"arena.width_m=-1.0", {"arena.width_m"}},
      {"arena.robots=3.5", {"arena.robots"}},
      {"arena.robots=5000", {"arena.robots", "too many"}},
      {"arena={use=\"null\",width_m=3,height_m=3,robots=1100}",
       {"arena.robots", "ids above 1022 cannot be addressed", "Scenario dhtf", "use at most 1023 robots"}},
      {"run.duration_s=3.0", {"run.duration_s", "whole number of periods"}},
      {"run.scenario=\"chess\"", {"run.scenario", "dhtf"}},
      {"arena.use=\"moon\"", {"arena.use", "ode"}},
      {"gate.slack=9", {"gate.slack", "8"}},
      {"shared.owner=\"nobody\"", {"shared.owner"}},
      {"lab.name=\"Not A Name\"", {"lab.name"}},
      {"scenario.dhtf.cells=\"some\"", {"scenario.dhtf.cells", "no_corners"}},
      {"preset=\"imagined\"", {"preset", "original", "paper"}},
      {"run.duration_s", {"--set"}},
  };
  for (const Case& c : cases) {
    CAPTURE(c.set);
    const Said said = run_with(c.set);
    CAPTURE(said.text);
    CHECK(said.code == 2);
    CHECK(one_sentence(said.text));
    for (const std::string& part : c.expected) CHECK(said.text.find(part) != std::string::npos);
  }
}

TEST_CASE("a lab with real robots refuses what only simulated ones have; one without says whose rules it has") {
  // Proves that no experiment becomes another one when it comes to a testbed.
  for (const char* set : {"arena.ode.infrared=\"argos\"", "arena.ode.ids=[100]"})
    for (const char* use : {"arena.use=kilobot", "arena.use=emulated"}) {
      const Said said = run_with(set, {"--set", use});
      CAPTURE(said.text);
      CHECK(said.code == 2);
      CHECK(one_sentence(said.text));
      CHECK(said.text.find(std::string(set).substr(0, 13)) != std::string::npos);
      CHECK(said.text.find("remove this key") != std::string::npos);
    }
  const tests::TemporaryFolder folder;
  for (const std::string rules : {"robot", "argos"}) {
    const auto out = folder.path() / rules;
    REQUIRE(say({"run", lab_file("shark"), "--set", "run.duration_s=4", "--set", "arena.ode.infrared=" + rules, "--out",
                 out.string()})
                .code == 0);
    std::ifstream result(out / "shark" / "result.json");
    const std::string text{std::istreambuf_iterator<char>(result), {}};
    CHECK(text.find("\"infrared\": \"" + rules + "\"") != std::string::npos);
  }
}

TEST_CASE(
    "a log that is missing, foreign, empty or too short for the run is refused by name; a cut one is played as far as "
    "it goes") {
  // Proves that a replay never invents poses.
  const tests::TemporaryFolder folder;
  const auto out = folder.path() / "recorded";
  REQUIRE(say({"run", lab_file("shark"), "--set", "run.duration_s=20", "--out", out.string()}).code == 0);
  const std::string log = (out / "shark" / "log.lcm").string();
  const auto replay = [&](const std::string& file, const std::string& duration = "20") {
    return run_with("arena.use=replay",
                    {"--set", fmt::format("arena.replay.log=\"{}\"", file), "--set", "run.duration_s=" + duration});
  };
  CHECK(replay(log).code == 0);
  const auto refused = [&](const Said& said, const std::string& name) {
    CAPTURE(said.text);
    CHECK(said.code == 2);
    CHECK(said.text.find("arkmesh: ") != std::string::npos);
    CHECK(said.text.find(name) != std::string::npos);
  };
  refused(replay("/nowhere/log.lcm"), "/nowhere/log.lcm");
  refused(replay(lab_file("shark")), "shark.toml");
  std::ofstream(folder.path() / "empty.lcm");
  refused(replay((folder.path() / "empty.lcm").string()), "empty.lcm");
  refused(replay(log, "40"), "log.lcm");
  const std::string bytes = tests::read_file(log);
  std::ofstream(folder.path() / "cut.lcm", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  refused(replay((folder.path() / "cut.lcm").string()), "cut.lcm");
  CHECK(replay((folder.path() / "cut.lcm").string(), "4").code == 0);
  // The same of a compressed one.
  const auto packed = folder.path() / "packed";
  REQUIRE(say({"run", lab_file("shark"), "--set", "run.duration_s=20", "--set", "recorder.compress=true", "--out",
               packed.string()})
              .code == 0);
  const std::string frames = tests::read_file(packed / "shark/log.lcm.zst");
  CHECK(frames.size() < bytes.size() / 2);
  CHECK(replay((packed / "shark/log.lcm.zst").string()).code == 0);
  std::ofstream(folder.path() / "cut.zst", std::ios::binary) << frames.substr(0, frames.size() / 2);
  refused(replay((folder.path() / "cut.zst").string()), "cut.zst");
  CHECK(replay((folder.path() / "cut.zst").string(), "4").code == 0);
}

TEST_CASE("a full disk stops the recording, and the run goes on to the same hash and fails") {
  // Proves that a run is worth more than its recording, and that nobody takes half a recording for a whole one.
  const std::string expected = [] {
    const tests::TemporaryFolder folder;
    REQUIRE(say({"run", lab_file("shark"), "--set", "run.duration_s=400", "--out", folder.path().string()}).code == 0);
    const std::string json = tests::read_file(folder.path() / "result.json");
    return json.substr(json.find("\"final_hash\""), 36);
  }();
  const tests::TemporaryFolder folder;
  // A file size limit in the child stands for the full disk: the write fails the same way. What compiling the
  // controller writes is smaller.
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{2'000'000, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  const Said said = say({"run", lab_file("shark"), "--set", "run.duration_s=400", "--out", folder.path().string()});
  ::setrlimit(RLIMIT_FSIZE, &before);
  CAPTURE(said.text);
  CHECK(said.code == 1);
  CHECK(
      said.text.find("failed: shark: all periods were run, but log and tables are incomplete: the recording stopped") !=
      std::string::npos);
  const std::string json = tests::read_file(folder.path() / "result.json");
  CHECK(json.find(expected) != std::string::npos);
  CHECK(json.find("recorder.not_recorded") != std::string::npos);
  CHECK(json.find("\"state\": \"failed\"") != std::string::npos);
}

TEST_CASE("what cannot be printed makes a command fail") {
  // Proves it for little, which is written at the end, and for much; of a reader that has had enough it is no failure.
  const auto code = [](const std::string& words) {
    const tests::TemporaryFolder folder;
    tests::Process process("/bin/bash", {"-c", "set -o pipefail; " + std::string(ARKMESH_PROGRAM) + words},
                           folder.path() / "said");
    return process.wait(300s).value_or(-1);
  };
  for (const char* words : {" --version", " scenario path", " config --keys"}) {
    CAPTURE(words);
    CHECK(code(words + std::string(" > /dev/full")) == 1);
    CHECK(code(words + std::string(" > /dev/null")) == 0);
  }
  CHECK(code(" scenario path | true") == 0);
}

TEST_CASE("a command line that cannot be meant is refused with exit code 2") {
  // Proves that scripts can tell wrong use from failure.
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{},
                                                    {"dance"},
                                                    {"run"},
                                                    {"run", "/nowhere.toml"},
                                                    {"lab"},
                                                    {"gateway"},
                                                    {"batch", lab_file("shark"), "--seeds", "1..2", "--jobs", "0"},
                                                    {"run", lab_file("shark"), lab_file("shark")}}) {
    const Said said = say(arguments);
    CAPTURE(said.text);
    CHECK(said.code == 2);
    CHECK_FALSE(said.text.empty());
  }
  for (const char* command : {"run", "up"}) {
    const Said said = say({command, lab_file("shark"), lab_file("roark"), lab_file("shark")});
    CHECK(said.code == 2);
    CHECK(said.text ==
          "arkmesh: " + lab_file("shark") + ": lab 'shark' is given twice; each file must name another lab\n");
  }
  const std::string labs = lab_file("shark") + " " + lab_file("roark");
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--seeds", "1..20", "--jobs", "2"}, {"--jobs", "2"}}) {
    std::vector<std::string> arguments = {"run", lab_file("shark"), lab_file("roark")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Said said = say(arguments);
    CHECK(said.code == 2);
    CHECK(said.text ==
          "arkmesh: arkmesh run performs one run; for several: arkmesh batch " + labs + " --seeds 1..20\n");
  }
  for (const char* command : {"run", "lab", "gateway", "doctor"}) {
    const Said said = say({command, "--help"});
    CHECK(said.code == 0);
    CHECK(said.text.find("Example") != std::string::npos);
  }
}
