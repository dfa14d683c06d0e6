// The labs of experiments/cre in one process: a short run that does something, twice alike.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/joint_run.hpp"
#include "tests/support/labs/dhtf_configs.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;

namespace {

struct CreOutcome {
  bool finished = false;
  std::uint64_t hash = 0;
  std::vector<std::map<std::string, std::uint64_t, std::less<>>> counts;  // by lab
  std::vector<std::string> swarms;                                        // swarms.csv by lab
  hal::Counters drops;
};

// Overrides for both labs, and for the ground and the flying lab alone.
CreOutcome run_cre(const std::vector<std::string>& overrides, const std::vector<std::string>& for_ground = {},
                   const std::vector<std::string>& for_flying = {}) {
  const tests::TemporaryFolder folder;
  std::vector<hal::Config> configs;
  for (const auto& [file, more] : {std::pair{"meadow.toml", for_ground}, {"sky.toml", for_flying}}) {
    std::vector<std::string> all = {"recorder.log=false"};
    all.insert(all.end(), overrides.begin(), overrides.end());
    all.insert(all.end(), more.begin(), more.end());
    configs.push_back(hal::Config::from_file(tests::experiments() / "cre" / file, all));
  }
  app::JointRun run(std::move(configs), folder.path());
  while (run.step()) {
  }
  CreOutcome out;
  out.finished = run.finished();
  out.hash = run.lab(0).runner().final_hash();
  for (std::size_t i = 0; i < run.size(); ++i) {
    out.counts.push_back(run.lab(i).runner().lab().counts().all());
    out.drops.merge(run.lab(i).runner().drops());
    std::ifstream in(folder.path() / run.lab(i).runner().lab().name() / "swarms.csv");
    out.swarms.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return out;
}

}  // namespace

TEST_CASE("cre: two runs with the same seed are alike, in every lab") {
  // Four minutes of the asymmetric experiment: the flying swarm has agreed on the south, the ground swarm harvests;
  // both labs say so in the same words, and so does a second run. Another seed gives another run.
  const std::vector<std::string> shortened = {"run.seed=1001", "run.duration_s=240"};
  const CreOutcome one = run_cre(shortened);
  REQUIRE(one.finished);
  CHECK(one.counts[0] == one.counts[1]);
  CHECK(one.swarms[0] == one.swarms[1]);
  CHECK(std::count(one.swarms[0].begin(), one.swarms[0].end(), '\n') == 122);  // header, boundaries 0 to 120
  CHECK(one.counts[0].at("consensus.south") == 1);
  CHECK(one.counts[0].at("ground.south_ppm") > 600'000);
  CHECK(one.counts[0].at("harvested.south") > 10);
  CHECK(one.drops["world.refused"] == 0);
  const CreOutcome two = run_cre(shortened);
  CHECK(two.hash == one.hash);
  CHECK(two.counts == one.counts);
  CHECK(two.swarms == one.swarms);
  CHECK(run_cre({"run.seed=1002", "run.duration_s=240"}).hash != one.hash);
}

TEST_CASE("cre: roles, not names, decide who does what") {
  // With other names, in the other order and owned by the other lab, the ground swarm harvests, and the flying swarm
  // agrees on the south.
  const CreOutcome renamed = run_cre({"run.seed=1001", "run.duration_s=240", "shared.labs=[\"ant\", \"zebra\"]",
                                      "shared.owner=ant", "shared.projection={ant={scale=4.0}, zebra={scale=1.0}}",
                                      "scenario.cre.roles={ground=\"zebra\", flying=\"ant\"}"},
                                     {"lab.name=zebra", "gateway.peers=[{lab=\"ant\"}]"},
                                     {"lab.name=ant", "gateway.peers=[{lab=\"zebra\", connect=\"127.0.0.1:7811\"}]"});
  REQUIRE(renamed.finished);
  CHECK(renamed.counts[0].at("consensus.south") == 1);
  CHECK(renamed.counts[0].at("harvested.south") > 10);
  CHECK(renamed.counts[0].at("ground.south_ppm") > 600'000);
}

TEST_CASE("cre: with the LEDs blanked nobody agrees and nobody follows") {
  // A scenario knows opinions by LEDs only; what ground robots harvest it knows by their poses.
  const CreOutcome blank = run_cre({"run.seed=1001", "run.duration_s=240", "arena.blank_leds=true"});
  REQUIRE(blank.finished);
  CHECK(blank.counts[0].at("consensus.south") + blank.counts[0].at("consensus.north") == 0);
  CHECK(blank.counts[0].at("flying.south_ppm") + blank.counts[0].at("flying.north_ppm") == 0);
  CHECK(blank.counts[0].at("ground.south_ppm") < 700'000);
  CHECK(blank.counts[0].at("harvested.south") > 10);
}

TEST_CASE("cre: the original's choices are a preset") {
  // It runs, with its own exchange period, and its robots do not give up by themselves: once all are committed they
  // stay.
  const CreOutcome original = run_cre({"run.seed=1001", "run.duration_s=240", "preset=original"});
  REQUIRE(original.finished);
  CHECK(std::count(original.swarms[0].begin(), original.swarms[0].end(), '\n') == 2402);
  CHECK(original.counts[0].at("consensus.held") == original.counts[0].at("consensus.periods"));
}
