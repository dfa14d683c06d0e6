// Labs that have finished and stay for their peers' sake.
#include <doctest/doctest.h>

#include <stdexcept>
#include <string_view>
#include <vector>

#include "app/joint_run.hpp"
#include "app/lab_files.hpp"
#include "arkmesh/fleet_command_t.hpp"
#include "hal/bus/bus.hpp"
#include "hal/record/event_log.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;

namespace {

// A step is a millisecond of the labs' time.
constexpr std::uint64_t second_steps = 1000;

app::LabFiles two_labs() {
  // Roark takes a step a period and shark twenty, so that shark has roark's last state when it finishes.
  app::LabFiles labs{.sets = {"arena.use=null", "run.duration_s=20", "gate.patience_s=8", "recorder.log=false",
                              "roark:arena.frame_period_s=2.0"}};
  for (const char* lab : {"shark.toml", "roark.toml"})
    labs.files.push_back((tests::experiments() / "dhtf" / lab).string());
  return labs;
}

// Shark has just finished, and its last state does not reach roark: the link is cut.
struct Finished {
  Finished() {
    run.network().impair("shark", "roark", {.delay_steps = 5});
    while (run.lab("shark").runner().state_text() != "finished") REQUIRE(run.step());
    run.network().set_up("shark", "roark", false);
    since = run.steps();
  }
  // Steps until shark has gone.
  std::uint64_t stay() {
    while (run.step() && !run.lab("shark").runner().finished() && run.steps() < since + 100 * second_steps) {
    }
    return run.steps() - since;
  }
  std::string_view outcome() { return run.lab("shark").runner().outcome(); }

  tests::TemporaryFolder folder;
  app::JointRun run{app::read_labs(two_labs(), 1), folder.path()};
  std::uint64_t since = 0;
};

}  // namespace

TEST_CASE("a lab that has finished waits no longer than its patience for a peer behind a cut link") {
  Finished labs;
  CHECK(labs.stay() < 9 * second_steps);
  CHECK(labs.outcome() == "finished");
}

TEST_CASE("a lab that has finished stays so when the operator stops it, and goes") {
  Finished labs;
  labs.run.lab("shark").runner().stop("stopped by the operator");
  CHECK(labs.stay() < 2 * second_steps);
  CHECK(labs.outcome() == "finished");
}

TEST_CASE("labs of one process end when all have what the others told last") {
  // Messages take three steps: one brings the last state, one that it came. Elsewhere each lab stays for 500 steps
  // more.
  app::LabFiles files = two_labs();
  files.sets.pop_back();
  tests::TemporaryFolder folder;
  app::JointRun run{app::read_labs(files, 1), folder.path()};
  const auto finished = [&](const char* lab) { return run.lab(lab).runner().outcome() == "finished"; };
  while (!finished("shark") || !finished("roark")) REQUIRE(run.step());
  run.network().impair("shark", "roark", {.delay_steps = 3});
  const std::uint64_t since = run.steps();
  while (run.step()) REQUIRE(run.steps() < since + 500);
  CHECK(run.steps() - since < 20);
  CHECK(run.finished());
}

TEST_CASE("a lab outlives its public bus") {
  // A process that an exception ends destroys the bus first; the lab then ends its run, and counts what was lost.
  app::LabFiles alone = two_labs();
  alone.files.resize(1);
  alone.sets.pop_back();
  alone.sets.insert(alone.sets.end(), {"shared.labs=[\"shark\"]", "gateway.peers=[]"});
  tests::TemporaryFolder folder;
  hal::EventLoop loop;
  app::ConfiguredLab lab(app::read_labs(alone, 1).front(), folder.path() / "run", loop);
  lab.open_run();
  {
    hal::Bus public_bus("memq://");
    const app::ConfiguredLab::Membership membership(lab, public_bus);
    public_bus.publish(std::string(100, 'c'), {});
    while (lab.runner().period() == 0) lab.runner().step(1s);
    CHECK(lab.runner().drops()["public_bus.refused.channel_name"] == 1);
  }
  lab.runner().fail("the lab was ended");
  CHECK(lab.runner().drops()["public_bus.refused.channel_name"] == 0);
}

TEST_CASE("robots are told to pause when the program that runs their labs ends by an exception") {
  // Wherever it comes from: nobody ended the labs.
  const tests::TemporaryFolder folder;
  app::LabFiles labs = two_labs();
  labs.sets.emplace_back("recorder.log=true");
  try {
    app::JointRun run(app::read_labs(labs, 1), folder.path());
    while (run.lab("roark").runner().period() < 2) REQUIRE(run.step());
    throw std::runtime_error("the program fails");
  } catch (const std::runtime_error&) {
  }
  for (const char* lab : {"shark", "roark"}) {
    hal::EventLogReader log(folder.path() / lab / "log.lcm");
    std::vector<int> said;
    while (const auto event = log.next())
      if (fleet_command_t m; event->channel == "fleet_command" && hal::decode(event->bytes, m))
        said.push_back(m.command);
    CHECK(said == std::vector<int>{fleet_command_t::run, fleet_command_t::pause});
  }
}
