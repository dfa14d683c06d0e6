// The programs of arkmesh: `arkmesh NAME` becomes the one that runs NAME, and each loads only what it needs.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "cli/command_table.hpp"
#include "tests/support/processes/process.hpp"
#include "tests/support/processes/sanitized.hpp"

namespace {

using namespace arkmesh;
using namespace arkmesh::tests;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

// A lab whose gateway listens for a peer that does not come, in a folder of its own.
struct Lab {
  TemporaryFolder folder;
  fs::path file = folder.path() / "shark.toml";
  mutable int started = 0;  // each says what it says into a file of its own

  Lab() {
    std::ofstream(file) << "[lab]\nname = \"shark\"\n[bus]\nurl = \"udpm://239.255.76.67:7861?ttl=0\"\n"
                           "[shared]\nlabs = [\"roark\", \"shark\"]\n"
                           "[gateway]\nlisten = \"127.0.0.1:7861\"\npeers = [{lab = \"roark\"}]\n";
  }
  Process start(const std::vector<std::string>& arguments, const std::string& program = ARKMESH_PROGRAM) const {
    return Process(program, arguments, folder.path() / fmt::format("said-{}.txt", started++));
  }
  // What the program said, which ends with this exit code.
  std::string said(int code, const std::vector<std::string>& arguments,
                   const std::string& program = ARKMESH_PROGRAM) const {
    Process process = start(arguments, program);
    CHECK(process.wait(300s) == code);
    return process.output();
  }
};

std::string program_of(const Process& process) {
  std::error_code gone;
  return fs::read_symlink(fmt::format("/proc/{}/exe", process.id()), gone).filename().string();
}

bool maps(const Process& process, const std::string& library) {
  return read_file(fmt::format("/proc/{}/maps", process.id())).find(library) != std::string::npos;
}

bool becomes(const Process& process, const std::string& program) {
  return eventually(300s, [&] { return program_of(process) == program; });
}

TEST_CASE("arkmesh becomes the program that runs the command") {
  // Under the process id that was started, so that signals reach it, and its exit code is the caller's.
  const Lab lab;
  for (const auto& row : {std::pair(SIGTERM, 0), std::pair(SIGINT, 0), std::pair(SIGKILL, 128 + SIGKILL)}) {
    const auto& [signal, code] = row;
    CAPTURE(row.first);
    Process gateway = lab.start({"gateway", lab.file.string()});
    REQUIRE(eventually(300s, [&] { return gateway.output().find("listening") != std::string::npos; }));
    CHECK(program_of(gateway) == "arkmesh-gateway");
    gateway.signal(signal);
    CHECK(gateway.wait(300s) == code);
  }
  CHECK(lab.said(2, {"gateway", lab.file.string(), "--set", "gateway.lisen=1"}).find("unknown key") !=
        std::string::npos);
  CHECK(lab.said(2, {"run", lab.file.string(), "--set", "run.scenario=none"}).starts_with("arkmesh: "));
  CHECK(lab.said(1, {"track", "nowhere.png"}).starts_with("arkmesh: there is no nowhere.png"));
}

TEST_CASE("help lists every command and loads nothing heavy") {
  const Lab lab;
  const std::string help = lab.said(0, {"--help"});
  for (const cli::CommandRow& row : cli::command_table()) {
    CAPTURE(row.name);
    CHECK(help.find(fmt::format("  {} ", row.name)) != std::string::npos);
    CHECK(help.find(row.purpose) != std::string::npos);
    CHECK(lab.said(0, {row.name, "--help"}).find(fmt::format("Usage: arkmesh {} ", row.name)) != std::string::npos);
  }
  const std::string libraries = lab.said(0, {"LD_TRACE_LOADED_OBJECTS=1", ARKMESH_PROGRAM, "--help"}, "/usr/bin/env");
  CHECK(libraries.find("libc.so") != std::string::npos);
  CHECK(libraries.find("opencv") == std::string::npos);
  CHECK(libraries.find("libode") == std::string::npos);
  CHECK(libraries.find("libssl") == std::string::npos);
}

TEST_CASE("a program that is missing is named") {
  // Only the folder of arkmesh itself counts: a PATH that leads to another copy does not.
  const Lab lab;
  const fs::path alone = lab.folder.path() / "bin";
  fs::create_directories(alone);
  fs::copy_file(ARKMESH_PROGRAM, alone / "arkmesh");
  const std::string path = "PATH=" + fs::path(ARKMESH_PROGRAM).parent_path().string();
  CHECK(lab.said(1, {path, (alone / "arkmesh").string(), "gateway", lab.file.string()}, "/usr/bin/env") ==
        fmt::format("arkmesh: arkmesh gateway needs the program arkmesh-gateway, which is not in {}; scripts/build "
                    "builds it, and an installation keeps all of arkmesh's programs in one folder\n",
                    alone.string()));
  CHECK(lab.said(0, {"--help"}, (alone / "arkmesh").string()).find("calibrate-motors") != std::string::npos);
  // A lab's arena is known once its file was read.
  fs::copy_file(ARKMESH_PROGRAM "-lab", alone / "arkmesh-lab");
  for (const std::string command : {"run", "lab"}) {
    CAPTURE(command);
    CHECK(lab.said(1, {command, lab.file.string(), "--set", "arena.use=emulated"}, (alone / "arkmesh").string()) ==
          fmt::format("arkmesh: {}: arena.use = \"emulated\" needs the program arkmesh-testbed, which is not in {}; "
                      "scripts/build builds it, and an installation keeps all of arkmesh's programs in one folder\n",
                      lab.file.string(), alone.string()));
  }
}

TEST_CASE("an idle gateway is small") {
  const Lab lab;
  Process gateway = lab.start({"gateway", lab.file.string()});
  REQUIRE(eventually(300s, [&] { return gateway.output().find("listening") != std::string::npos; }));
  CHECK(maps(gateway, "liblcm"));
  CHECK_FALSE(maps(gateway, "opencv"));
  CHECK_FALSE(maps(gateway, "libode"));
  if (sanitized) return;
  const std::string status = read_file(fmt::format("/proc/{}/status", gateway.id()));
  const int resident_kb = std::stoi(status.substr(status.find("VmRSS:") + 6));
  CAPTURE(resident_kb);
  CHECK(resident_kb > 1000);
  CHECK(resident_kb <= 12 * 1024);
}

TEST_CASE("a simulated lab loads no OpenCV") {
  const Lab lab;
  const std::vector<std::string> words = {"lab",   std::string(ARKMESH_SOURCE_DIR) + "/experiments/dhtf/shark.toml",
                                          "--out", lab.folder.path() / "out",
                                          "--set", "bus.url=\"udpm://239.255.76.67:7862?ttl=0\""};
  Process simulated = lab.start(words);
  REQUIRE(becomes(simulated, "arkmesh-lab"));
  REQUIRE(eventually(300s, [&] { return fs::exists(lab.folder.path() / "out" / "config.toml"); }));
  CHECK(maps(simulated, "libode"));
  CHECK_FALSE(maps(simulated, "opencv"));
}

TEST_CASE("a lab with cameras is run by the program that has them") {
  const Lab lab;
  Process emulators =
      lab.start({"lab", std::string(ARKMESH_SOURCE_DIR) + "/experiments/dhtf/roark_emulated.toml", "--out",
                 lab.folder.path() / "out", "--set", "bus.url=\"udpm://239.255.76.67:7863?ttl=0\""});
  REQUIRE(becomes(emulators, "arkmesh-testbed"));
  CHECK(eventually(300s, [&] { return maps(emulators, "opencv"); }));
}

}  // namespace
