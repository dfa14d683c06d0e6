// A killed lab's robots, by the truth of an emulated testbed.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

constexpr auto guarded_deadline = 300s;

const std::string spinner = R"(#include <kilolib.h>
static void setup(void) {}
static void loop(void) { spinup_motors(); set_motors(kilo_turn_left, 0); delay(200); }
int main(void) { kilo_init(); kilo_start(setup, loop); return 0; }
)";

const std::string spinners = R"([emulator]
frames_per_s = 10.0
camera_port = 8090
ohc_port = 8091
control_port = 8092
[[emulator.camera]]
name = "camera0"
width_px = 320
height_px = 240
z_m = 0.95
focal_px = 400.0
[arena]
robots = 2
width_m = 0.5
height_m = 0.5
[arena.ode]
controller = "spinner.c"
)";

const std::string their_lab = R"([lab]
name = "a"
[run]
scenario = "dhtf"
duration_s = 100
[scenario.dhtf.requirements]
a = [1, 2]
[shared]
labs = ["a"]
[arena]
use = "kilobot"
robots = 2
width_m = 0.5
height_m = 0.5
[arena.kilobot]
port = "tcp://127.0.0.1:8091"
settle_s = 0
[[arena.kilobot.cameras]]
source = "http://127.0.0.1:8090/camera0"
calibration = "camera.yaml"
)";

// When robot 0 had which heading, as text; whole lines only.
std::map<double, std::string> headings(const std::filesystem::path& truth) {
  const std::string text = tests::read_file(truth);
  std::istringstream rows(text.substr(0, text.rfind('\n') + 1));
  std::map<double, std::string> out;
  for (std::string row; std::getline(rows, row);) {
    std::istringstream in(row);
    std::string cells[6];
    for (std::string& cell : cells) std::getline(in, cell, ',');
    if (cells[1] == "0") out[std::stod(cells[0])] = cells[5];
  }
  return out;
}

}  // namespace

TEST_CASE("robots stand as soon as a lab listens, and are told to when it is killed, whoever makes them walk") {
  // The lab never finds these robots, so nobody has seen them stand: its guard tells them for a minute.
  const tests::TemporaryFolder folder;
  const auto file = [&](const std::string& name) { return (folder.path() / name).string(); };
  std::ofstream(file("spinner.c")) << spinner;
  std::ofstream(file("testbed.toml")) << spinners;
  std::ofstream(file("a.toml")) << their_lab;
  const std::string truth = file("truth.csv");
  const auto latest = [&] {
    const auto all = headings(truth);
    return all.empty() ? 0.0 : all.rbegin()->first;
  };
  const auto says = [&](tests::Process& process, const std::string& words) {
    return tests::eventually(guarded_deadline,
                             [&] { return process.output().find(words) != std::string::npos || !process.running(); }) &&
           process.running();
  };
  tests::Process testbed(ARKMESH_PROGRAM,
                         {"emulator", file("testbed.toml"), "--truth", truth, "--calibration", file("camera.yaml")},
                         file("testbed.txt"));
  REQUIRE(says(testbed, "commands:"));
  tests::Process run(ARKMESH_PROGRAM, {"ohc", "tcp://127.0.0.1:8091", "run"}, file("ohc.txt"));
  REQUIRE(run.wait(guarded_deadline) == 0);
  REQUIRE(tests::eventually(guarded_deadline, [&] {
    const auto all = headings(truth);
    return std::any_of(all.begin(), all.end(), [&](const auto& row) { return row.second != all.begin()->second; });
  }));
  tests::Process lab(ARKMESH_PROGRAM, {"lab", file("a.toml"), "--out", file("out")}, file("lab.txt"));
  const bool listens = says(lab, "the overhead controller listens");
  const std::string said = lab.output();
  CAPTURE(said);
  REQUIRE(listens);

  const auto turned = [&](double from_s, double to_s) {
    REQUIRE(tests::eventually(guarded_deadline, [&] { return latest() > to_s || !testbed.running(); }));
    const auto all = headings(truth);
    const auto first = all.lower_bound(from_s), last = all.lower_bound(to_s);
    REQUIRE(first != last);
    return std::any_of(first, last, [&](const auto& row) { return row.second != first->second; });
  };
  const double listens_s = latest();
  CHECK_FALSE(turned(listens_s + 6, listens_s + 8));  // what the file holds lags

  lab.kill();
  const double killed_s = latest();
  CHECK_FALSE(turned(killed_s + 6, killed_s + 8));
  // Another program gets the controller at once, and its robots are its own business.
  tests::Process runs(ARKMESH_PROGRAM, {"ohc", "tcp://127.0.0.1:8091", "run"}, file("ohc.txt"));
  CHECK(runs.wait(guarded_deadline) == 0);
  const double runs_s = latest();
  CHECK(turned(runs_s, runs_s + 10));
}
