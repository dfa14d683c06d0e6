// The example's platform and scenario the whole way: configuration, lab, recording.
#include "tests/examples/greeting/greeting.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>

#include "app/arenas.hpp"
#include "app/joint_run.hpp"
#include "app/scenarios.hpp"
#include "hal/arenas/messages.hpp"
#include "hal/record/event_log.hpp"
#include "hal/stop_request.hpp"
#include "tests/examples/rover/rover_arena.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

void add_rows() {
  if (std::ranges::find(app::arena_rows(), "rover", &hal::ArenaRow::name) == app::arena_rows().end())
    app::arena_rows().push_back(examples::rover::rover_arena_row());
  if (std::ranges::find(app::catalogue(), "greeting", &app::CatalogueEntry::name) == app::catalogue().end())
    app::catalogue().push_back(examples::greeting::greeting());
}

// How many messages from robots a recording holds.
std::size_t recorded_answers(const std::filesystem::path& log) {
  hal::EventLogReader reader(log);
  std::size_t answers = 0;
  while (const auto event = reader.next()) {
    from_robots_t message;
    if (event->channel != hal::channel::from_robots || !hal::decode(event->bytes, message)) continue;
    answers += static_cast<std::size_t>(message.n_messages);
  }
  return answers;
}

}  // namespace

TEST_CASE("greeting: a lab of rovers is heard by its scenario and its recording") {
  // Four rovers answer each greeting; the lab ends when it has twelve answers, and count, table and recording agree.
  add_rows();
  const tests::TemporaryDirectory folder;
  std::vector<hal::Config> configs;
  configs.push_back(hal::Config::from_text(
      "[lab]\nname = \"rovers\"\n[run]\nscenario = \"greeting\"\nduration_s = 20\n[gate]\nperiod_s = 0.5\n"
      "[arena]\nuse = \"rover\"\nrobots = 4\nframe_period_s = 0.05\n[scenario.greeting]\nanswers = 12\n",
      "rovers.toml"));
  app::JointRun run(std::move(configs), folder.path());
  const nlohmann::json result = run.run(hal::nobody_stops(), nullptr);
  CHECK(run.finished());
  const auto& counts = run.lab("rovers").runner().lab().counts();
  CHECK(counts["answers"] >= 12);
  CHECK(counts["answers"] <= counts["greetings"]);
  CHECK(recorded_answers(folder.path() / "rovers" / "log.lcm") == counts["answers"]);
  std::ifstream table(folder.path() / "rovers" / "answers.csv");
  const auto lines = std::count(std::istreambuf_iterator<char>(table), {}, '\n');
  CHECK(static_cast<std::uint64_t>(lines) == 1 + counts["answers"]);
}

TEST_CASE("greeting: what robots say reaches a scenario in Python") {
  // The same in Python: each answer is told once, with the frame after it.
  add_rows();
  ::setenv("ARKMESH_PYTHON", "/usr/bin/python3", 0);
  const tests::TemporaryDirectory folder;
  folder.write(
      "greeting.py",
      "import arkmesh\n\nclass Greeting(arkmesh.Scenario):\n"
      "    def frame(self, lab):\n        lab.count('answers', len(lab.heard))\n"
      "        for said in lab.heard:\n            lab.row('answers', robot=said['robot'], value=said['value'])\n\n"
      "    def period(self, lab):\n        lab.say(lab.ids, value=lab.periods % 8)\n");
  const auto file = folder.write("rovers.toml",
                                 "[lab]\nname = \"rovers\"\n[run]\nscenario = \"greeting.py\"\nduration_s = 5\n[gate]\n"
                                 "period_s = 0.5\n[arena]\nuse = \"rover\"\nrobots = 4\nframe_period_s = 0.05\n");
  std::vector<hal::Config> configs;
  configs.push_back(hal::Config::from_file(file));
  app::JointRun run(std::move(configs), folder.path() / "out");
  run.run(hal::nobody_stops(), nullptr);
  REQUIRE(run.finished());
  const std::uint64_t counted = run.lab("rovers").runner().lab().counts()["answers"],
                      recorded = recorded_answers(folder.path() / "out" / "rovers" / "log.lcm");
  CHECK(counted > 12);
  CHECK(recorded >= counted);
  CHECK(recorded - counted <= 4);  // those behind the last frame
}
