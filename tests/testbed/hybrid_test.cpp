// Hybrids: one swarm is simulated, the other stands on an emulated testbed, seen by a camera and told by an overhead
// controller; they share one world.
#include <doctest/doctest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "hal/config/config.hpp"
#include "tests/support/processes/process.hpp"
#include "tests/support/processes/thorough.hpp"

using namespace arkmesh;

namespace {

// Labs of experiments/FOLDER in one process, until they have ended.
struct Hybrid {
  Hybrid(const std::string& folder_name, const std::vector<std::string>& files, std::vector<std::string> overrides) {
    overrides.push_back("recorder.log=false");
    std::vector<hal::Config> configs;
    for (const std::string& file : files)
      configs.push_back(hal::Config::from_file(
          std::string(ARKMESH_SOURCE_DIR) + "/experiments/" + folder_name + "/" + file + ".toml", overrides));
    run.emplace(std::move(configs), folder.path());
    while (run->step()) {
    }
    for (std::size_t i = 0; i < run->size(); ++i) reason += run->lab(i).runner().reason();
  }
  const lab::Runner& lab(const char* name) { return run->lab(name).runner(); }
  // A simulated lab waits for the testbed, so it has told its state before the testbed's lab merges that boundary.
  void check_in_time() {
    for (std::size_t i = 0; i < run->size(); ++i) {
      const hal::Counters drops = run->lab(i).runner().drops();
      for (const auto& drop : drops.all()) {
        CAPTURE(drop.first);
        CHECK_MESSAGE(!drop.first.starts_with("gate."), drop.second);
      }
    }
  }
  tests::TemporaryFolder folder;
  std::optional<app::JointRun> run;
  std::string reason;
};

}  // namespace

TEST_CASE("hybrid: DHTF's shark in ODE and roark on an emulated testbed complete tasks together") {
  // Proves that a lab behind pictures and bytes and a simulated one play one game.
  Hybrid labs("dhtf", {"shark", "roark_emulated"}, {"run.duration_s=30", "scenario.dhtf.types=easy"});
  CAPTURE(labs.reason);
  REQUIRE(labs.run->finished());
  CHECK_FALSE(labs.lab("shark").strict());
  labs.check_in_time();
  CHECK(labs.lab("shark").lab().counts()["completed"] > 0);
  CHECK(labs.lab("roark").lab().state("roark").robots.size() == 12);
  CHECK(labs.lab("roark").arena().info().platform != labs.lab("shark").arena().info().platform);
}

TEST_CASE("hybrid: CRE's flying swarm on an emulated testbed and its ground swarm in ODE share one world" *
          doctest::skip(!arkmesh::tests::thorough())) {
  // Proves that densities reach flying robots through the overhead controller, and that what their LEDs then show comes
  // back through the camera: the simulated lab merges robots that have committed themselves.
  Hybrid labs("cre", {"meadow", "sky_emulated"}, {"run.duration_s=60"});
  CAPTURE(labs.reason);
  REQUIRE(labs.run->finished());
  CHECK_FALSE(labs.lab("meadow").strict());
  labs.check_in_time();
  const std::vector<lab::SharedRobot>& flying = labs.lab("meadow").lab().state("sky").robots;
  CHECK(flying.size() == 20);
  CHECK(std::ranges::count_if(flying, [](const lab::SharedRobot& robot) {
          return robot.led == hal::Led::red || robot.led == hal::Led::blue;
        }) > 0);
}
