// The parts of a batch that need no process: its plan, its tables, and when a folder is gone on with.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "app/batch/batch_file.hpp"
#include "app/batch/batch_folder.hpp"
#include "app/batch/batch_manifest.hpp"
#include "app/batch/batch_results.hpp"
#include "app/batch/batch_table.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
namespace fs = std::filesystem;

namespace {

// An experiment file beside two empty files that stand for labs.
struct ExperimentFile {
  tests::TemporaryDirectory folder;

  app::BatchPlan plan(const std::string& text, const std::string& seeds = {},
                      const std::vector<std::string>& sets = {}) {
    return app::read_batch_file({write(text)}, seeds, sets).plan;
  }
  std::string error(const std::string& text, const std::vector<std::string>& sets = {}) {
    try {
      app::read_batch_file({write(text)}, {}, sets);
    } catch (const hal::ConfigError& wrong) {
      return wrong.what();
    }
    return "nothing";
  }

 private:
  fs::path write(const std::string& text) {
    folder.write("a.toml", "");
    folder.write("b.toml", "");
    return folder.write("batch.toml", text);
  }
};

const std::string begin = "labs = [\"a.toml\", \"b.toml\"]\nseeds = \"1..3\"\n";

void write_result(const fs::path& batch, std::size_t run, const std::string& json) {
  const fs::path folder = app::BatchFolder::run_folder(batch, run);
  fs::create_directories(folder);
  std::ofstream(folder / "result.json") << json;
}

}  // namespace

TEST_CASE("batch: ranges have whole or exact values, with the last one") {
  using Values = std::vector<std::string>;
  CHECK(app::range_values("1..4") == Values{"1", "2", "3", "4"});
  CHECK(app::range_values("0..10 step 5") == Values{"0", "5", "10"});
  CHECK(app::range_values("0..10 step 4") == Values{"0", "4", "8"});
  CHECK(app::range_values("0..0.3 step 0.1") == Values{"0.0", "0.1", "0.2", "0.3"});  // 3 * 0.1 > 0.3 in doubles
  CHECK(app::range_values("-1..0") == Values{"-1", "0"});
  for (const char* bad : {"", "1", "1..", "..2", "2..1", "1..2 step 0", "1..2 step -1", "1..2 step", "a..b", "1..inf",
                          "nan..1", "1..2x", "0..1e9 step 1e-9"}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(app::range_values(bad), std::invalid_argument);
  }
}

TEST_CASE("batch: seeds are ranges and numbers, none of them twice") {
  CHECK(app::seeds_of({"3..5", "1"}) == std::vector<std::int64_t>{3, 4, 5, 1});
  for (const std::vector<std::string>& bad :
       {std::vector<std::string>{"1..5", "5..9"}, {"2", "2"}, {"-1"}, {"-2..2"}, {"1.5"}, {"x"}, {}})
    CHECK_THROWS_AS(app::seeds_of(bad), std::invalid_argument);
}

TEST_CASE("batch: a plan is a grid in the order of the file, and its runs keep their numbers") {
  ExperimentFile file;
  const app::BatchPlan plan =
      file.plan(begin +
                "[set]\nrun.duration_s = 60\n"
                "[sweep]\n\"gate.period_s\" = [2, 0.5]\n\"a:arena.robots\" = \"10..20 step 10\"\n"
                "[choices.pair.wide]\narena.width_m = 2.0\narena.height_m = 2.0\n"
                "[choices.pair.plain]\n");
  REQUIRE(plan.factors.size() == 3);
  CHECK(plan.factors[0].name == "gate.period_s");
  CHECK(plan.factors[1].name == "a:arena.robots");
  CHECK(plan.factors[2].name == "pair");
  CHECK(plan.settings() == 8);
  CHECK(plan.runs() == 24);
  CHECK(plan.labels_of(0) == std::vector<std::string>{"2", "10", "wide"});
  CHECK(plan.labels_of(7) == std::vector<std::string>{"0.5", "20", "plain"});
  CHECK(plan.labs_of(4).sets == std::vector<std::string>{"recorder.log=false", "run.duration_s=60", "gate.period_s=0.5",
                                                         "a:arena.robots=10", "arena.width_m=2.0",
                                                         "arena.height_m=2.0"});
  CHECK(plan.seed_of(13) == 2);
  CHECK(plan.setting_of(13) == 4);
  std::set<std::pair<std::size_t, std::int64_t>> all;
  for (std::size_t run = 0; run < plan.runs(); ++run) all.emplace(plan.setting_of(run), plan.seed_of(run));
  CHECK(all.size() == 24);
}

TEST_CASE("batch: an experiment may include another one, and the command line has the last word") {
  ExperimentFile file;
  file.folder.write("below.toml", begin + "[set]\nrun.duration_s = 60\n[sweep]\ngate.slack = [0, 1]\n");
  const app::BatchPlan plan =
      file.plan("include = [\"below.toml\"]\n[set]\nrun.duration_s = 8\n", "7..8", {"gate.period_s=4"});
  CHECK(plan.seeds == std::vector<std::int64_t>{7, 8});
  CHECK(plan.labs.files.size() == 2);
  CHECK(plan.labs.sets == std::vector<std::string>{"recorder.log=false", "run.duration_s=8", "gate.period_s=4"});
  CHECK(plan.settings() == 2);
}

TEST_CASE("batch: impossible experiments are refused in one sentence that names the place") {
  ExperimentFile file;
  const auto refused = [&](const std::string& text, const std::string& with) {
    const std::string said = file.error(text);
    CAPTURE(text);
    CAPTURE(said);
    CHECK(said.find(with) != std::string::npos);
    CHECK(said.find("batch.toml") != std::string::npos);
    CHECK(said.find('\n') == std::string::npos);
  };
  refused("", "names no labs");
  refused("labs = [\"a.toml\"]\n", "names no seeds");
  refused("labs = []\nseeds = 1\n", "must be a list of the labs' files");
  refused("labs = [\"c.toml\"]\nseeds = 1\n", "there is no file");
  refused("labs = [\"a.toml\"]\nseeds = []\n", "at least one seed");
  refused("labs = [\"a.toml\"]\nseeds = [\"1..5\", 3]\n", "seed 3 is listed twice");
  refused("labs = [\"a.toml\"]\nseeds = \"5..1\"\n", "must be a range");
  refused(begin + "[sweeps]\ngate.slack = [1]\n", "did you mean 'sweep'?");
  refused(begin + "[sweep]\ngate.slack = []\n", "must be a list of values");
  refused(begin + "[sweep]\ngate.slack = 1\n", "must be a list of values");
  refused(begin + "[sweep]\ngate.slack = [1, 1]\n", "1 is listed twice");
  refused(begin + "[sweep]\ngate.slack = \"many\"\n", "must be a range");
  refused(begin + "[sweep]\nrun.seed = [1, 2]\n", "the experiment's seeds");
  refused(begin + "[set]\nshared.labs = [\"a\"]\n", "seeds and labs determine it");
  refused(begin + "[sweep]\ngate.slack = [1]\n[choices.x.y]\ngate.slack = 2\n",
          "gate.slack is already set by gate.slack");
  refused(begin + "choices = 3\n", "a choice is a table");
  refused(begin + "[choices]\nx = 3\n", "a choice is a table");
  refused(begin + "[choices.x]\ny = 3\n", "must be a table of the keys");
  refused(begin + "[[plot]]\ncolumn = \"completed\"\n", "needs column and over");
  refused(begin + "[[plot]]\ncolumn = \"completed\"\nover = \"mix\"\n", "neither swept nor a choice");
  refused(begin + "[[plot]]\ncolour = \"red\"\n", "a plot has no such key");
  refused(begin + "[sweep]\nx = \"1..1000\"\ny = \"1..1000\"\n", "at most 1000000");
  refused(begin + "[sweep\n", "not valid TOML");
  CHECK(file.error(begin + "[sweep]\ngate.slack = [0, 1]\n", {"gate.slack=2"}).find("--set gate.slack=2") == 0);
}

TEST_CASE("batch: its table has a row for each run that has ended, and no wall time") {
  const tests::TemporaryFolder folder;
  ExperimentFile file;
  const app::BatchPlan plan = file.plan(begin + "[sweep]\ngate.slack = [0, 1]\n");
  write_result(folder.path(), 0, R"({"state": "finished", "ended": "finished", "final_hash": "11", "periods": 9,
      "duration_s": 18.5, "counts": {"completed": 7, "first.ms": 4}, "wall": {"speed": 3.5},
      "by_lab": {"a": {"counters": {"x": 2}, "wall": {"total_s": 1}, "between_labs": {"b": {"received_bytes": 5}}}}})");
  write_result(folder.path(), 1, R"({"state": "failed", "ended": "why, \"so\"", "seed": 2})");
  write_result(folder.path(), 3, R"({"state": "finished", "ended": "finished", "counts": {"lapsed": 1}})");
  // another run's tables that a full disk has cut are no result
  write_result(folder.path(), 4, R"({"state": "finished", "ended": "finished", "counts": {"completed": 9},
      "drops": {"a.recorder.not_recorded.disk_full": 1}})");
  write_result(folder.path(), 5, "{ half a res");
  write_result(folder.path(), 2, R"({"state": "stopped", "ended": "stopped", "counts": {"completed": 3}})");
  const app::BatchResults results(plan, folder.path());
  CHECK(results.finished() == 2);
  results.save();
  CHECK(tests::read_file(folder.path() / "runs.csv") ==
        "run,setting,gate.slack,seed,state,why,final_hash,completed,first.ms,lapsed,duration_s,periods\n"
        "0,0,0,1,finished,,11,7,4,0,18.5,9\n"
        "1,0,0,2,failed,\"why, \"\"so\"\"\",,,,,,\n"
        "3,1,1,1,finished,,,0,,1,,0\n");
  // what labs and links counted has a table of its own, with the same first columns
  CHECK(tests::read_file(folder.path() / "counters.csv") ==
        "run,setting,gate.slack,seed,a.between.b.received_bytes,a.x\n0,0,0,1,5,2\n1,0,0,2,,\n3,1,1,1,0,0\n");
}

TEST_CASE("batch: the summary tells of each setting, and the effects of settings that differ in one thing") {
  const tests::TemporaryFolder folder;
  ExperimentFile file;
  const app::BatchPlan plan = file.plan(begin + "[sweep]\ngate.slack = [0, 1]\nx = [5, 6]\n");
  for (std::size_t run = 0; run < plan.runs(); ++run)
    write_result(folder.path(), run,
                 fmt::format(R"({{"state": "finished", "ended": "finished", "counts": {{"n": {}}}}})",
                             10 * plan.setting_of(run) + 1 + run % 3));
  app::BatchResults(plan, folder.path()).save();
  // 1, 2, 3: sd 1, se 1/sqrt(3); three runs are too few for an interval
  CHECK(tests::read_file(folder.path() / "summary.csv")
            .starts_with("setting,gate.slack,x,column,n,mean,sd,se,low95,high95,min,median,max,interval,reached\n"
                         "0,0,5,n,3,2,1,0.57735,,,1,2,3,\"mean, no interval\",3\n1,0,6,n,3,12,1,"));
  // Hedges' correction for 3 + 3 is 1 - 3/15
  const std::string effects = tests::read_file(folder.path() / "effects.csv");
  CHECK(effects.find("\nn,gate.slack,0,1,0,2,3,3,20,,,16,1,mean\n") != std::string::npos);
  CHECK(effects.find("\nn,x,5,6,2,3,3,3,10,,,8,1,mean\n") != std::string::npos);
  CHECK(std::ranges::count(effects, '\n') == 5);  // header, and 0-2, 1-3, 0-1, 2-3
}

TEST_CASE("batch: labs' files with seeds are a plan of one setting") {
  tests::TemporaryDirectory folder;
  const fs::path a = folder.write("a.toml", "[lab]\nname = \"a\"\n"), b = folder.write("b.toml", "lab.name = \"b\"\n");
  const fs::path experiment = folder.write("batch.toml", begin);
  for (const std::vector<fs::path>& files : {std::vector{a}, {a, b}}) {
    const app::BatchFile batch = app::read_batch_file(files, "4..6", {"gate.slack=1"});
    CHECK(batch.experiment.empty());
    CHECK(batch.plan.labs.files.size() == files.size());
    CHECK(batch.plan.labs.files.front() == a.string());
    CHECK(batch.plan.labs.sets == std::vector<std::string>{"recorder.log=false", "gate.slack=1"});
    CHECK(batch.plan.settings() == 1);
    CHECK(batch.plan.seeds == std::vector<std::int64_t>{4, 5, 6});
  }
  CHECK_THROWS_WITH(app::read_batch_file({a, b}, "", {}), "lab files contain no seeds; add --seeds 1..20");
  for (const std::vector<fs::path>& files : {std::vector{a, experiment}, {experiment, a}, {experiment, experiment}})
    CHECK_THROWS_WITH(
        app::read_batch_file(files, "1..2", {}),
        (experiment.string() + ": has no [lab], so it is not a lab's file; give one experiment file, or the "
                               "labs' files")
            .c_str());
}

TEST_CASE("batch: what differs from the beginning of a folder is named") {
  const tests::TemporaryDirectory folder;
  const std::string lab = folder.write("a.toml", "a").string();
  const nlohmann::json begun = {{"arkmesh", "0.1"},
                                {"versions", {{"commit", "abc"}, {"build", "Release"}}},
                                {"experiment", {{"text", ""}}},
                                {"labs", {"a"}},
                                {"set", {"x=1"}},
                                {"factors", nlohmann::json::array()},
                                {"seeds", {1, 2}},
                                {"inputs", {{lab, "af63dc4c8601ec8c"}}}};  // FNV-1a of "a"
  CHECK(app::difference(begun, begun).empty());
  const auto with = [&](const std::string& key, const nlohmann::json& value) {
    nlohmann::json now = begun;
    now[key] = value;
    return app::difference(begun, now);
  };
  CHECK(with("arkmesh", "0.2") ==
        "it was started with arkmesh 0.1 (commit abc, Release), but this is arkmesh 0.2 (commit abc, Release)");
  CHECK(with("labs", {"b"}) == "it was started with other labs");
  CHECK(with("seeds", {1}) == "it was started with other seeds");
  CHECK(with("set", {"x=2"}).find("other settings of all runs") != std::string::npos);
  CHECK(with("factors", {1}).find("another grid") != std::string::npos);
  folder.write("a.toml", "b");
  CHECK(app::difference(begun, begun) == lab + " has changed since it was started");
  CHECK(app::difference({{"state", "finished"}}, begun) == "it contains no batch manifest");
}
