// Labs in one process that wait for the wall clock say how they are meanwhile.
#include <doctest/doctest.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "hal/messages.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

TEST_CASE("a run of real-time arenas whose frames are far apart says each second how it is") {
  // The first frame after the beginning is five seconds away; nobody is lost in these.
  const tests::TemporaryFolder folder;
  app::JointRun run(tests::dhtf_configs({.overrides = {"arena.use=null", "arena.pace=1.0", "arena.frame_period_s=5.0",
                                                       "gate.period_s=5.0", "run.duration_s=10"}}),
                    folder.path());
  std::map<std::string, int> statuses;
  std::vector<std::unique_ptr<hal::Bus::Subscription>> heard;
  for (std::size_t i = 0; i < run.size(); ++i)
    heard.push_back(run.lab(i).bus().subscribe(
        hal::channel::status, [&statuses, name = run.lab(i).name()](auto, auto) { ++statuses[name]; }));
  for (const auto end = std::chrono::steady_clock::now() + 2500ms; std::chrono::steady_clock::now() < end;)
    REQUIRE(run.step());
  for (const auto& status : statuses) {
    CAPTURE(status.first);
    CHECK(status.second >= 3);
    CHECK(status.second <= 4);
  }
  CHECK(statuses.size() == 2);
}
