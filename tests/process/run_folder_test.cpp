// Run folders of real processes: who is refused leaves everything as it was, and a result is never lost.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/labs/lab_processes.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

const std::string shark_file = ARKMESH_SOURCE_DIR "/experiments/dhtf/shark.toml";

nlohmann::json result_of(const fs::path& folder) {
  return nlohmann::json::parse(tests::read_file(folder / "result.json"), nullptr, false);
}

// `arkmesh run` of shark alone, in a shell.
tests::Process in_shell(const std::string& command, const fs::path& said) {
  return tests::Process("/bin/sh", {"-c", command}, said);
}

}  // namespace

TEST_CASE("a start that is refused leaves no folder, and a run that is there as it is") {
  tests::LabProcesses labs({.overrides = {"arena.use=null", "arena.pace=1.0", "gate.patience_s=60"}});
  labs.start_lab("shark");
  REQUIRE(labs.reached("shark", 0, 300s));
  CHECK(labs.result("shark", "state") == "running");
  const tests::TemporaryFolder folder;
  auto start = [&, started = 0](const fs::path& out, const std::vector<std::string>& more) mutable {
    std::vector<std::string> words = {"lab", shark_file, "--out", out.string(), "--set", "shared.labs=[\"shark\"]"};
    words.insert(words.end(), more.begin(), more.end());
    tests::Process lab(ARKMESH_PROGRAM, words, folder.path() / fmt::format("said-{}.txt", ++started));
    CHECK(lab.wait(300s) == 2);
    return lab.output();
  };
  const std::string same_port = "bus.url=\"" + labs.bus_url("shark") + "\"",
                    other_port = "bus.url=\"udpm://239.255.76.67:7977?ttl=0\"";
  CHECK(start(folder.path() / "a", {"--set", same_port}).find("is on this LCM port") != std::string::npos);
  CHECK(start(folder.path() / "b", {"--set", other_port, "--set", "arena.nonsense=1"}).find("arena.nonsense") !=
        std::string::npos);
  CHECK_FALSE(fs::exists(folder.path() / "a"));
  CHECK_FALSE(fs::exists(folder.path() / "b"));
  CHECK(start(labs.directory("shark"), {"--set", other_port, "--force"}).find("the run of roark, shark (process") !=
        std::string::npos);
  // Killed, its result says "running" of a process that is gone, and the next start beside it says what that means.
  labs.lab("shark").kill();
  CHECK(labs.result("shark", "state") == "running");
  CHECK(start(labs.directory("shark"), {"--set", other_port}).find("is not empty") != std::string::npos);
  CHECK(labs.result("shark", "state") == "killed");
}

TEST_CASE("a full disk has room for the result") {
  // A file system of 600 KiB in a name space of our own; nothing is kept free.
  const tests::TemporaryFolder folder;
  const std::string disk = (folder.path() / "disk").string(), kept = (folder.path() / "kept.json").string();
  fs::create_directory(disk);
  tests::Process run = in_shell(
      fmt::format("exec unshare -m sh -c 'mount -t tmpfs -o size=600k none {0} && {1} run {2} --out {0}/run --set "
                  "run.duration_s=400 --set recorder.keep_free_mib=0; code=$?; df -k {0}; cp {0}/run/shark/result.json "
                  "{3}; exit $code'",
                  disk, ARKMESH_PROGRAM, shark_file, kept),
      folder.path() / "said.txt");
  CHECK(run.wait(300s) == 1);
  const std::string said = run.output();
  CAPTURE(said);
  CHECK(said.find("recording in") != std::string::npos);  // stopped
  const nlohmann::json result = nlohmann::json::parse(tests::read_file(kept), nullptr, false);
  REQUIRE(result.is_object());
  CHECK(result.at("state") == "failed");
  CHECK(result.at("ended").get<std::string>().find("the recording stopped") != std::string::npos);
}

TEST_CASE("a disk with less than is to stay free is refused before anything moves") {
  const tests::TemporaryFolder folder;
  const std::string disk = (folder.path() / "disk").string();
  fs::create_directory(disk);
  tests::Process run = in_shell(
      fmt::format(
          "exec unshare -m sh -c 'mount -t tmpfs -o size=30m none {0} && {1} run {2} --out {0}/run; code=$?; ls "
          "{0}/run/shark; exit $code'",
          disk, ARKMESH_PROGRAM, shark_file),
      folder.path() / "said.txt");
  CHECK(run.wait(300s) == 1);
  const std::string said = run.output();
  CAPTURE(said);
  CHECK(said.find("make room there (recorder.keep_free_mib = 64 stays free)") != std::string::npos);
  CHECK(said.find("log.lcm") == std::string::npos);
}

TEST_CASE("a file is no folder for results, nor is the folder where one is") {
  const tests::TemporaryFolder folder;
  const std::string file = (folder.path() / "lab.toml").string();
  std::ofstream(file) << "mine";
  const auto said = [&](const std::string& out) {
    tests::Process run = in_shell(fmt::format("cd {} && exec {} run {} --seconds 2 --force --out {}",
                                              folder.path().string(), ARKMESH_PROGRAM, shark_file, out),
                                  folder.path() / "said.txt");
    CHECK(run.wait(300s) == 2);
    return run.output();
  };
  CHECK(said("lab.toml").find("lab.toml is a file; give a folder with --out") != std::string::npos);
  CHECK(said(".").find("is the current folder") != std::string::npos);
  CHECK(tests::read_file(file) == "mine");
}

TEST_CASE("a run is repeated from its folder, which holds the program, its headers and what is said of single robots") {
  // Proves it for headers beside the C files, above them, in folders of their own and behind macros, after all of them
  // are gone.
  const tests::TemporaryFolder folder;
  const fs::path mine = folder.path() / "mine";
  for (const char* name : {"lab/robots", "lab/own", "common"}) fs::create_directories(mine / name);
  std::ofstream(mine / "lab/robots/walk.c")
      << "#include <kilolib.h>\n#include \"near.h\"\n#include \"../../common/far.h\"\n#include <own.h>\n"
         "#include NAMED\nvoid setup() {}\nvoid loop() { set_color(NEAR + FAR + OWN + OTHER); set_motors(70, 70); }\n"
         "int main() { kilo_init(); kilo_start(setup, loop); return 0; }\n";
  std::ofstream(mine / "lab/robots/near.h") << "#include \"nearer.h\"\n";
  std::ofstream(mine / "lab/robots/nearer.h") << "#define NEAR 1\n";
  std::ofstream(mine / "common/far.h") << "#define FAR 4\n";
  std::ofstream(mine / "lab/own/own.h") << "#define OWN 16\n";
  std::ofstream(mine / "lab/own/named.h") << "#define OTHER 0\n";
  std::ofstream(mine / "robots.toml") << "[[robot]]\nid = 0\nspeed_m_per_s = 0.02\n";
  std::ofstream(mine / "lab/a.toml")
      << "[lab]\nname = \"a\"\n[shared]\nlabs = [\"a\"]\n[run]\nscenario = \"still.py\"\nduration_s = 6\n[bus]\nurl = "
         "\"udpm://239.255.76.67:7719?ttl=0\"\n"
         "[arena]\nrobots = 3\n[arena.ode]\ncontroller = \"robots/walk.c\"\ninclude = [\"own\"]\n"
         "define = ['NAMED=\"named.h\"']\nrobots_file = \"../robots.toml\"\n";
  std::ofstream(mine / "lab/still.py") << "import arkmesh\n\n\nclass Still(arkmesh.Scenario):\n    pass\n";
  const auto run = [&](const std::string& words) {
    tests::Process process = in_shell(
        fmt::format("cd {} && exec {} {}", folder.path().string(), ARKMESH_PROGRAM, words), folder.path() / "said.txt");
    const int code = process.wait(300s).value_or(-1);
    CAPTURE(process.output());
    CHECK(code == 0);
    return process.output();
  };
  run("run mine/lab/a.toml --out first");
  fs::remove_all(mine);
  fs::create_directory(folder.path() / "moved");
  fs::rename(folder.path() / "first", folder.path() / "moved/first");
  CHECK(run("rerun moved/first").find("equal: final hash") != std::string::npos);
  for (const char* name : {"lab/robots/walk.c", "lab/robots/near.h", "lab/robots/nearer.h", "common/far.h",
                           "lab/own/own.h", "lab/own/named.h", "robots.toml"})
    CHECK(fs::exists(folder.path() / "moved/first/a/files" / name));
}

TEST_CASE("a run folder that is removed is said once, and the result is printed") {
  tests::LabProcesses labs({.overrides = {"arena.pace=1.0", "gate.period_s=0.5"}});
  labs.start();
  REQUIRE(labs.reached("shark", 3, 300s));
  fs::remove_all(labs.directory("shark"));
  REQUIRE(labs.reached("shark", 6, 300s));
  labs.lab("shark").signal(SIGTERM);
  CHECK(labs.lab("shark").wait(300s) == 3);
  const std::string said = labs.lab_output("shark");
  CAPTURE(said);
  const std::size_t first = said.find("the folder was removed");
  CHECK(first != std::string::npos);
  CHECK(said.find("the folder was removed", first + 1) == std::string::npos);
  CHECK(said.find("\"state\": \"stopped\"") != std::string::npos);
}

TEST_CASE("a result says what it was made with") {
  const tests::TemporaryFolder folder;
  const auto run = [&](const std::string& name) {
    tests::Process process(ARKMESH_PROGRAM,
                           {"run", shark_file, "--out", (folder.path() / name).string(), "--set", "run.duration_s=2"},
                           folder.path() / "said.txt");
    CHECK(process.wait(300s) == 0);
    return result_of(folder.path() / name / "shark");
  };
  const nlohmann::json first = run("first"), second = run("second");
  for (const char* what : {"commit", "build", "compiler", "glibc", "lcm", "ode"})
    CHECK(first.at("versions").at(what).is_string());
  CHECK(first.at("hashes").at("dhtf.c").get<std::string>().size() == 16);
  CHECK(first.at("hashes").contains("config.toml"));
  CHECK(first.at("hashes") == second.at("hashes"));
  CHECK(first.at("files") == nlohmann::json{"shark.toml", "common.toml", "presets/paper.toml"});
  CHECK(first.at("started").get<std::string>().ends_with("Z"));
}
