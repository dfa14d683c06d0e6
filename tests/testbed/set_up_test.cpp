// The set-up procedures before an experiment on an emulated testbed, with the truth beside: cameras, controller and
// robots' programs are those of a real testbed.
#include "app/testbed/set_up.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "emulator/emulator_record.hpp"
#include "testbed/assign_ids.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;

namespace {

// A lab whose testbed is an emulated one with so many robots, files and all.
class EmulatedLab {
 public:
  explicit EmulatedLab(int robots, const std::string& ids = "shuffled", double side_m = 0.5) {
    const auto emulator = folder_.path() / "emulator.toml", calibration = folder_.path() / "testbed.yaml";
    const std::string arena =
        fmt::format("[arena]\nrobots = {}\nwidth_m = {}\nheight_m = {}\n", robots, side_m, side_m);
    std::ofstream(emulator)
        << fmt::format(
               "[emulator]\nids = \"{}\"\n{}[arena.ode]\ncontroller = \"{}/scenarios/dhtf/controller/dhtf.c\"\n", ids,
               arena, ARKMESH_SOURCE_DIR)
        << "[[emulator.camera]]\nname = \"camera0\"\nwidth_px = 640\nheight_px = 480\nz_m = 0.95\nfocal_px = 800.0\n";
    const hal::Config config = hal::Config::from_file(emulator, {"emulator.seed=1"});
    const emulator::Emulator first(config.root());
    emulator::write_calibration(first, calibration.string());
    truth_ = first.truth();
    std::ofstream(file())
        << fmt::format(
               "[lab]\nname = \"roark\"\n[run]\nscenario = \"dhtf\"\nduration_s = 60.0\nseed = 1\n[shared]\nlabs = "
               "[\"roark\"]\n{}",
               arena)
        << fmt::format(
               "use = \"emulated\"\nemulated.file = \"{}\"\n[[arena.kilobot.cameras]]\nsource = \"0\"\ncalibration = "
               "\"{}\"\n",
               emulator.string(), calibration.string());
  }
  std::filesystem::path file() const { return folder_.path() / "lab.toml"; }
  // Where robots stand when the emulator begins, with their ids.
  const std::vector<emulator::Emulator::Truth>& truth() const { return truth_; }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  tests::TemporaryFolder folder_;
  std::vector<emulator::Emulator::Truth> truth_;
};

class SilentProgress final : public hal::Progress {
  void show(const std::string&) override {}
  void show(std::uint32_t, std::uint32_t, double, const std::string&) override {}
  void done() override {}
  void say(const std::string&) override {}
};

bool is_there(const std::vector<emulator::Emulator::Truth>& truth, hal::RobotId robot, double x_m, double y_m) {
  return std::ranges::any_of(truth, [&](const auto& each) {
    return each.id == robot && std::hypot(each.seen.pose.x_m - x_m, each.seen.pose.y_m - y_m) < 0.01;
  });
}

}  // namespace

TEST_CASE("testbed: identify on an emulated testbed") {
  // The program's testbed has every robot where the emulator knows it to stand.
  const EmulatedLab lab(8);
  tests::Process process(ARKMESH_PROGRAM, {"identify", lab.file().string()}, lab.folder() / "output.txt");
  CHECK(process.wait(std::chrono::seconds(120)) == 0);
  CAPTURE(process.output());
  std::istringstream lines(process.output());
  int right = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    unsigned robot = 0;
    double x_m = 0, y_m = 0;
    if (words >> robot >> x_m >> y_m) right += is_there(lab.truth(), static_cast<hal::RobotId>(robot), x_m, y_m);
  }
  CHECK(right == 8);
}

TEST_CASE("testbed: assign-ids on an emulated testbed") {
  // Robots without any id get those wanted, each one of its own, and spell them.
  const EmulatedLab lab(8, "unassigned");
  testbed::SetUpArena testbed = app::make_set_up_arena(lab.file().string(), {}, "assign_ids.c", hal::nobody_stops());
  CHECK(testbed.is_simulated());
  std::vector<hal::RobotId> ids(8);
  std::iota(ids.begin(), ids.end(), hal::RobotId{200});
  SilentProgress progress;
  const testbed::AssignIdsReport report =
      testbed::assign_ids(testbed, {.ids = ids, .session = 7}, hal::nobody_stops(), progress);
  CHECK(report.finished);
  CHECK(report.confirmed == 8);
  REQUIRE(report.robots.size() == 8);
  std::set<hal::RobotId> given;
  std::set<int> told;  // by number in the simulation
  for (const auto& robot : report.robots) {
    CHECK(robot.outcome == tracker::IdAssigner::Outcome::confirmed);
    REQUIRE(robot.given.has_value());
    given.insert(static_cast<hal::RobotId>(*robot.given));
    for (const auto& each : lab.truth())
      if (std::hypot(each.seen.pose.x_m - robot.in_arena.x_m, each.seen.pose.y_m - robot.in_arena.y_m) < 0.01)
        told.insert(each.robot);
  }
  CHECK(given == std::set<hal::RobotId>(ids.begin(), ids.end()));
  CHECK(told.size() == 8);
}

TEST_CASE("testbed: calibrate-motors on an emulated testbed") {
  // Through cameras and controller each robot finds duties and shows that it has stored them.
  const EmulatedLab lab(2);
  tests::Process process(ARKMESH_PROGRAM, {"calibrate-motors", lab.file().string()}, lab.folder() / "output.txt");
  CHECK(process.wait(std::chrono::seconds(400)) == 0);
  CAPTURE(process.output());
  CHECK(process.output().find("2 of 2 robots calibrated and stored") != std::string::npos);
}
