// Labs in one process that wait for the wall clock say how they are meanwhile.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/joint_run.hpp"
#include "hal/arenas/messages.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/processes/process.hpp"
#include "tests/support/processes/run_delay.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

TEST_CASE("a run of real-time arenas whose frames are far apart says each second how it is") {
  // The first frame after the beginning is five seconds away; nobody is lost in these.
  const tests::TemporaryFolder folder;
  app::JointRun run(tests::dhtf_configs({.overrides = {"arena.use=null", "arena.pace=1.0", "arena.frame_period_s=5.0",
                                                       "gate.period_s=5.0", "run.duration_s=1000"}}),
                    folder.path());
  std::map<std::string, int> statuses;
  std::vector<std::unique_ptr<hal::Bus::Subscription>> heard;
  for (std::size_t i = 0; i < run.size(); ++i)
    heard.push_back(run.lab(i).bus().subscribe(
        hal::channel::status, [&statuses, name = run.lab(i).name()](auto, auto) { ++statuses[name]; }));
  const auto begun = std::chrono::steady_clock::now();
  const tests::OwnTime own;
  const auto all_have_said = [&](int times) {
    return statuses.size() == 2 && std::ranges::all_of(statuses, [&](const auto& lab) { return lab.second >= times; });
  };
  while (!all_have_said(3)) {
    REQUIRE(run.step());
    REQUIRE(std::chrono::steady_clock::now() - begun < 300s);
  }
  CHECK(own.passed() < 4s);  // two seconds when nothing else runs
  const auto took = std::chrono::steady_clock::now() - begun;
  for (const auto& status : statuses) {
    CAPTURE(status.first);
    CHECK(status.second <= 2 + took / 1s);
  }
  CHECK(statuses.size() == 2);
}
