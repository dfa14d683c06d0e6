// What a lab's result says of who kept its robots still, and of robots that were not seen to stand.
#include "lab/result.hpp"

#include <doctest/doctest.h>

#include "hal/bus/loss.hpp"
#include "hal/record/result_file.hpp"
#include "tests/lab/runner_bench.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using nlohmann::json;

namespace {

lab::RunConfig ten_periods() {
  lab::RunConfig config = tests::config_of_one_lab();
  config.last_period = 10;
  return config;
}

json result_of(const lab::Runner& runner) {
  return lab::lab_result({{"lab", "a"}}, runner, {}, {});
}

void go_on_to(tests::Bench& bench, std::uint32_t period) {
  while (bench.runner.period() < period) {
    REQUIRE(bench.step() != lab::Runner::Step::ended);
    REQUIRE(bench.now < 10s);
  }
}

}  // namespace

TEST_CASE("a result lists who kept robots still and when, in lab time, and leaves open what stood at the end") {
  tests::Bench bench(ten_periods());
  go_on_to(bench, 2);
  CHECK(result_of(bench.runner).at("pauses") == json::array());
  bench.tell(fleet_command_t::pause);
  go_on_to(bench, 4);
  bench.tell(fleet_command_t::run);
  go_on_to(bench, 6);
  bench.tell(fleet_command_t::pause);
  bench.run();
  const json result = result_of(bench.runner);
  CHECK(hal::outcome_in(result) == hal::Outcome::finished);
  const json& pauses = result.at("pauses");
  REQUIRE(pauses.size() == 2);
  CHECK(pauses[0].at("who") == "operator");
  CHECK(pauses[0].at("from_s").get<double>() == doctest::Approx(0.5).epsilon(0.3));
  CHECK(pauses[0].at("until_s").get<double>() == doctest::Approx(1.0).epsilon(0.3));
  CHECK(pauses[1].at("from_s").get<double>() == doctest::Approx(1.5).epsilon(0.2));
  CHECK(pauses[1].at("until_s").is_null());
}

TEST_CASE("a result names robots that were not seen to stand, with the reason; also of an arena that was lost") {
  using Why = hal::NotStanding::Why;
  tests::Bench bench;
  bench.arena.seen_to_walk = {{3, Why::not_told}, {4, Why::not_yet}, {7, Why::moving}, {9, Why::not_in_sight}};
  go_on_to(bench, 1);
  CHECK(result_of(bench.runner).at("not_standing") == json::array());  // robots should run
  bench.run();
  const json expected = {{{"robot", 3}, {"why", "not told"}},
                         {{"robot", 4}, {"why", "not yet"}},
                         {{"robot", 7}, {"why", "moving"}},
                         {{"robot", 9}, {"why", "not in sight"}}};
  json result = result_of(bench.runner);
  CHECK(result.at("not_standing") == expected);
  CHECK(result.at("pauses") == json::array());
  result.update({{"arkmesh", ""},
                 {"versions", {}},
                 {"started", ""},
                 {"process", {}},
                 {"labs", {"a"}},
                 {"scenario", ""},
                 {"seed", 1}});
  const json joint = lab::joint_result({result});
  CHECK(joint.at("by_lab").at("a").at("not_standing") == expected);
  CHECK(joint.at("by_lab").at("a").at("pauses") == json::array());
  CHECK_FALSE(joint.contains("not_standing"));

  tests::Bench lost;
  lost.arena.seen_to_walk = bench.arena.seen_to_walk;
  go_on_to(lost, 1);
  lost.arena.gone = true;
  lost.run();
  CHECK(hal::outcome_in(result_of(lost.runner)) == hal::Outcome::failed);
  CHECK(result_of(lost.runner).at("not_standing") == expected);
}

TEST_CASE("words say which messages were mostly lost, with reason and cause, and nothing of few") {
  const auto words = [](std::initializer_list<std::pair<const char*, std::uint64_t>> counts) {
    hal::Counters counters;
    for (const auto& [name, n] : counts) counters.set(name, n);
    return hal::loss_words(counters, "arena.");
  };
  const auto only = [&](std::initializer_list<std::pair<const char*, std::uint64_t>> counts, const char* begins) {
    const std::vector<std::string> said = words(counts);
    REQUIRE(said.size() == 1);
    CHECK(said[0].starts_with(begins));
  };
  CHECK(words({}).empty());
  CHECK(words({{"arena.infrared.sent", 100}, {"arena.infrared.refused.crc", 50}}).empty());
  CHECK(words({{"to_robots.offered", 1000}, {"to_robots.replaced", 200}, {"to_robots.refused", 400}}).empty());
  only({{"arena.infrared.sent", 24'578}, {"arena.infrared.refused.crc", 24'578}, {"arena.infrared.pairs.deaf", 3}},
       "24578 of 24578 infrared messages refused: their checksum does not match their content");
  only({{"arena.infrared.sent", 9}, {"arena.infrared.refused.type", 9}}, "9 of 9 infrared messages kept from programs");
  only({{"arena.infrared.sent", 999}, {"arena.infrared.pairs.in_reach", 684}, {"arena.infrared.pairs.deaf", 26}},
       "26 of 684 pairs in reach heard nothing of each other for a minute or longer: usually two");
  only({{"arena.infrared.sent", 999}, {"arena.infrared.pairs.deaf", 26}, {"arena.infrared.lost.crowded", 1}},
       "26 of 0 pairs in reach heard nothing of each other for a minute or longer: by ARGoS's rules");
  only({{"arena.overhead.heard", 3}, {"arena.overhead.distorted", 9}}, "9 of 12 overhead messages refused");
  only({{"to_robots.offered", 9}, {"to_robots.refused", 8}}, "8 of 9 words to robots refused");
  only({{"to_robots.offered", 458}, {"to_robots.replaced", 358}},
       "358 of 458 words to robots replaced by newer ones before they were sent: they need 458 % of the overhead");
}

TEST_CASE("a run with cameras ends with how well they followed the robots") {
  // Proves the roots of the means, and that nothing is said where nobody was followed.
  hal::Counters counters;
  CHECK(hal::tracking_words(counters, "arena.").empty());
  counters.set("arena.track.places", 100);
  counters.set("arena.track.places.off_um2", 16'000'000);
  counters.set("arena.track.places.misfit", 2'500);
  CHECK(hal::tracking_words(counters, "arena.") ==
        "tracked robots were seen 0.40 mm from their predicted places, 0.50 times the stated deviation; "
        "0 robots had been mistaken for another");
  counters.set("arena.track.headings", 50);
  counters.set("arena.track.headings.off_mrad2", 125'000);
  counters.set("arena.track.headings.misfit", 20'000);
  counters.set("arena.track.renamed", 1);
  CHECK(hal::tracking_words(counters, "arena.") ==
        "tracked robots were seen 0.40 mm from their predicted places, 0.50 times the stated deviation; their "
        "LEDs 2.9 degrees, 2.00 times; 1 robot had been mistaken for another");
}

TEST_CASE("a joint result failed when any lab did, else it was stopped when any lab was, and names the lab") {
  const auto one = [](const std::string& name, hal::Outcome outcome, const std::string& why) {
    json lab = {{"lab", name}};
    for (const char* key :
         {"arkmesh",      "versions", "started",    "process",    "labs",        "scenario",    "seed",
          "gate",         "periods",  "duration_s", "final_hash", "hash_by_lab", "counts",      "pauses",
          "not_standing", "counters", "exchange",   "wall",       "peers",       "between_labs"})
      lab[key] = nullptr;
    lab["drops"] = lab["counts"] = json::object();
    hal::set_outcome(lab, outcome, why);
    return lab;
  };
  using hal::Outcome;
  const auto outcome = [&](Outcome a, Outcome b) {
    const json joint = lab::joint_result({one("a", a, "one reason"), one("b", b, "another")});
    return std::pair(hal::outcome_in(joint).value(), hal::ended_in(joint));
  };
  CHECK(outcome(Outcome::finished, Outcome::stopped) == std::pair(Outcome::stopped, std::string("b: another")));
  CHECK(outcome(Outcome::failed, Outcome::stopped) == std::pair(Outcome::failed, std::string("b: another")));
  CHECK(outcome(Outcome::stopped, Outcome::failed) == std::pair(Outcome::failed, std::string("b: another")));
  CHECK(outcome(Outcome::failed, Outcome::finished) == std::pair(Outcome::failed, std::string("a: one reason")));
  CHECK(outcome(Outcome::finished, Outcome::finished).first == Outcome::finished);
}

TEST_CASE("a joint result sums what labs counted, and has once what all tell alike") {
  // Whichever lab comes first, and where only one of them counted.
  const auto one = [](const std::string& name, json counts, json shared) {
    json lab = {{"lab", name}, {"counts", std::move(counts)}, {"shared_counts", std::move(shared)}};
    for (const char* key : {"arkmesh", "versions", "started", "process", "labs", "scenario", "seed", "gate", "periods",
                            "duration_s", "final_hash", "hash_by_lab", "pauses", "not_standing", "counters", "exchange",
                            "wall", "peers", "between_labs"})
      lab[key] = nullptr;
    lab["drops"] = json::object();
    hal::set_outcome(lab, hal::Outcome::finished, "finished");
    return lab;
  };
  const json a = one("a", {{"lit", 3}, {"completed", 7}}, {"completed"}),
             b = one("b", {{"lit", 4}, {"lit1", 5}, {"completed", 7}}, {"completed"});
  const json wanted = {{"completed", 7}, {"lit", 7}, {"lit@a", 3}, {"lit@b", 4}, {"lit1", 5}, {"lit1@b", 5}};
  CHECK(lab::joint_result({a, b}).at("counts") == wanted);
  CHECK(lab::joint_result({b, a}).at("counts") == wanted);
  CHECK(lab::joint_result({b}).at("counts") == b.at("counts"));
}
