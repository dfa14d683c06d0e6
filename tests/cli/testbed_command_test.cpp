// `arkmesh testbed record` and `replay`, and `--record` of a set-up procedure, as a user meets them.
#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/processes/process.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

struct TestbedEnd {
  int code = -1;
  std::string said;
  bool says(const std::string& part) const { return said.find(part) != std::string::npos; }
};

TestbedEnd testbed_command(const tests::TemporaryFolder& folder, const std::vector<std::string>& arguments) {
  tests::Process process(ARKMESH_PROGRAM, arguments, folder.path() / "output.txt");
  const auto code = process.wait(std::chrono::seconds(180));
  return {code.value_or(-1), process.output()};
}

const std::string testbed_experiments = std::string(ARKMESH_SOURCE_DIR) + "/experiments/";

}  // namespace

TEST_CASE("testbed: a run is recorded and replayed") {
  // Proves that `record` leaves a run folder with its record, that `replay` tells what robots heard and finds the same
  // poses, and that a folder that holds something and an arena without devices are refused.
  const tests::TemporaryDirectory folder;
  const std::string day = folder.path() / "day";
  const std::vector<std::string> record{"testbed",
                                        "record",
                                        testbed_experiments + "dhtf/roark_emulated.toml",
                                        "--out",
                                        day,
                                        "--seconds",
                                        "4",
                                        "--set",
                                        "shared.labs=[\"roark\"]",
                                        "--set",
                                        "shared.owner=roark"};
  const TestbedEnd recorded = testbed_command(folder, record);
  CAPTURE(recorded.said);
  CHECK(recorded.code == 0);
  CHECK(recorded.says("the record takes"));
  CHECK(recorded.says("lab roark finished: 2 periods"));
  for (const char* file : {"config.toml", "log.lcm", "result.json", "raw/serial.txt", "raw/looks.txt", "raw/log.txt",
                           "raw/facts.json", "raw/calibration/0.yaml", "raw/camera0/000000.png"})
    CHECK(std::filesystem::file_size(std::filesystem::path(day) / file) > 0);

  const TestbedEnd replayed = testbed_command(folder, {"testbed", "replay", day});
  CAPTURE(replayed.said);
  CHECK(replayed.code == 0);
  CHECK(replayed.says("  identification query 118: 40"));
  CHECK(replayed.says("  run\n"));
  CHECK(replayed.says("  pause\n"));
  CHECK(replayed.says("poses: 41 frames"));
  CHECK(replayed.says("0 frames differ; at most 0.0000 mm and 0.0000 degrees"));

  const TestbedEnd again = testbed_command(folder, record);
  CHECK(again.code == 2);
  CHECK(again.says("is a folder that is not empty"));
  const TestbedEnd simulated = testbed_command(
      folder, {"testbed", "record", testbed_experiments + "dhtf/roark.toml", "--out", folder.path() / "none"});
  CHECK(simulated.code == 2);
  CHECK(simulated.says("arena.use = \"ode\": has no devices to record"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "none"));
  const TestbedEnd nothing = testbed_command(folder, {"testbed", "replay", folder.path()});
  CHECK(nothing.code == 1);
  CHECK(nothing.says("is not a testbed record"));
}

TEST_CASE("testbed: a set-up procedure is recorded") {
  // Proves that what was asked before any lab ran can be replayed, too.
  const tests::TemporaryDirectory folder;
  const std::string day = folder.path() / "day";
  const TestbedEnd identified = testbed_command(
      folder, {"identify", testbed_experiments + "dhtf/roark.toml", "--set", "arena.use=emulated", "--record", day});
  CAPTURE(identified.said);
  CHECK(identified.code == 0);
  const TestbedEnd replayed = testbed_command(folder, {"testbed", "replay", day});
  CAPTURE(replayed.said);
  CHECK(replayed.code == 0);
  CHECK(replayed.says("  identification query 118: 40"));
  CHECK(replayed.says("the record does not come from a lab's run"));
}
