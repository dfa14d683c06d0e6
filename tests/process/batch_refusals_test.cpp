// What `arkmesh batch` and `arkmesh rerun` refuse, and a run that is repeated from its folder.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/process/batch_bench.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::BatchBench, tests::small_batch, tests::small_labs;
namespace fs = std::filesystem;

TEST_CASE("a batch refuses in one sentence what cannot be run, before anything starts") {
  BatchBench bench;
  const auto refused = [&](const std::string& text, const std::string& with, std::vector<std::string> more = {}) {
    const auto [code, words] = bench.batch(bench.file(text), "refused", std::move(more));
    const std::string said = words;
    CAPTURE(text);
    CAPTURE(said);
    CHECK(code == 2);
    CHECK(said.find(with) != std::string::npos);
    const auto sentence = said.find("arkmesh: ");  // a slow machine shows the progress of the check before
    REQUIRE(sentence != std::string::npos);
    CHECK(said.find('\n', sentence) == said.size() - 1);
    CHECK_FALSE(fs::exists(bench.folder.path() / "refused"));
  };
  refused(small_batch + "gate.perid_s = [1, 2]\n", "did you mean 'gate.period_s'?");
  refused(small_batch + "gate.perid_s = [1, 2]\n", "small.toml:9: gate.perid_s=1");
  refused(small_batch + "arena.ode.friction = [0.1, -1]\n", "arena.ode.friction=-1");
  refused(small_batch + "\"roark:arena.robots\" = [1, 2]\n", "there is no lab roark");
  refused(small_batch + "gate.slack = [0, 99]\n", "must be between 0 and 8");
  refused(small_labs + "seeds = 1\n[sweep]\nrun.scenario = [\"dhtf\", \"chess\"]\n", "is none of: ");
  refused(small_labs + "seeds = [\"1..4\", \"4..6\"]\n", "seed 4 is listed twice");
  refused(small_labs + "seeds = 1\n[set]\narena.use = \"kilobot\"\n", "");
  refused(small_labs + "seeds = 1\n[sweep]\ngate.period_s = [2, 2.0]\n", "2.0 is listed twice");
  refused(small_labs + "seeds = 1\n[sweep]\nrun.duration_s = \"0..9223372036854775807 step 4611686018427387904\"\n",
          "run.duration_s = 0: must be between");  // both values fit into 64 bits, and neither is a duration
  refused(small_labs + "seeds = 1\n[choices.seed.a]\n", "is already a column of the table");
  refused("labs = [\"/tmp\"]\nseeds = 1\n", "/tmp is a folder; name the lab's file");
  refused("labs = [3]\nseeds = 1\n", "3 is not a file name");
  refused(small_batch, "the batch has runs 0..15", {"--index", "16"});
  refused(small_batch, "holds no batch", {"--gather"});
  refused(small_batch, "holds no batch", {"--plot", "completed", "--over", "gate.period_s"});
  refused(small_batch, "--seeds 5..2", {"--seeds", "5..2"});
  refused(small_batch, "the experiment itself varies this key", {"--set", "gate.period_s=4"});
}

TEST_CASE("a batch's folder is gone on with by the same experiment and version only") {
  BatchBench bench;
  const std::string text = small_labs + "seeds = \"1..2\"\n[set]\nrun.duration_s = 4\narena.robots = 2\n";
  REQUIRE(bench.batch(bench.file(text), "out").first == 0);
  const auto refused = [&](const std::string& changed, const std::string& with, std::vector<std::string> more = {}) {
    const auto [code, words] = bench.batch(bench.file(changed), "out", std::move(more));
    const std::string said = words;
    CAPTURE(said);
    CHECK(code == 2);
    CHECK(said.find(with) != std::string::npos);
    CHECK(said.find("give another folder with --out") != std::string::npos);
  };
  refused(text + "gate.period_s = 1\n", "started with other settings of all runs");
  refused(text, "started with other seeds", {"--seeds", "1..3"});
  refused(text + "[sweep]\ngate.slack = [0, 1]\n", "started with another grid");
  refused(text + "# a word\n", "small.toml has changed since it was started");
  CHECK(bench.batch(bench.file(text), "out").first == 0);
  // from another folder, with relative names
  tests::Process elsewhere(
      "/bin/sh",
      {"-c", fmt::format("cd {} && {} batch small.toml --out out", bench.folder.path().string(), ARKMESH_PROGRAM)},
      bench.folder.path() / "elsewhere.txt");
  CHECK(elsewhere.wait(300s) == 0);
  const fs::path manifest = bench.folder.path() / "out/manifest.json";
  nlohmann::json other = nlohmann::json::parse(tests::read_file(manifest));
  other["arkmesh"] = "0.0.1";
  std::ofstream(manifest) << other;
  refused(text, "it was started with arkmesh 0.0.1");
  // what there is can still be looked at
  CHECK(bench.batch(bench.file(text), "out", {"--gather"}).first == 0);
  fs::create_directory(bench.folder.path() / "full");
  std::ofstream(bench.folder.path() / "full/thesis.tex") << "years";
  const auto [code, said] = bench.batch(bench.file(text), "full");
  CHECK(code == 2);
  CHECK(said.find("is not the folder of a batch") != std::string::npos);
}

TEST_CASE("results and a manifest that somebody else wrote are no reason to crash") {
  BatchBench bench;
  const fs::path file = bench.file(small_labs + "seeds = \"1..4\"\n[set]\nrun.duration_s = 4\narena.robots = 2\n");
  const fs::path out = bench.folder.path() / "out";
  REQUIRE(bench.batch(file, "out").first == 0);
  const std::string table = bench.table("out");
  const auto write = [&](const std::string& name, const std::string& text) { std::ofstream(out / name) << text; };
  write("runs/00000/result.json", "[[[");
  write("runs/00001/result.json", R"({"state": 5})");
  write("runs/00002/result.json", R"({"state": "failed", "counts": 3, "by_lab": [1], "ended": 7, "final_hash": {}})");
  write("runs/00003/result.json", R"({"state": "failed", "by_lab": {"a": 3}, "drops": []})");
  const auto gathered = bench.batch(file, "out", {"--gather"});
  CHECK(gathered.second.find("2 runs are unfinished") != std::string::npos);
  CHECK(bench.batch(file, "out", {"--retry"}).first == 0);
  CHECK(bench.table("out") == table);
  for (const char* const result :
       {R"({"labs": [], "state": "finished", "gate": "strict"})", R"({"labs": 3, "state": [], "gate": 1})",
        R"({"labs": ["../../x"], "state": "finished", "gate": "strict"})"}) {
    write("runs/00000/result.json", result);
    const auto [code, said] = bench.run({"rerun", (out / "runs/00000").string()});
    CHECK(code == 2);
    CHECK(std::ranges::count(said, '\n') == 1);
  }
  write("manifest.json", R"({"experiment": 1, "versions": 3, "inputs": []})");
  const auto [code, words] = bench.batch(file, "out");
  const std::string said = words;
  CAPTURE(said);
  CHECK(code == 2);
  CHECK(said.find("it was started with arkmesh ? (commit ?, ?)") != std::string::npos);
}

TEST_CASE("one run is done by one process at a time") {
  BatchBench bench;
  const fs::path file = bench.file(small_labs + "seeds = \"1..2\"\n[set]\nrun.duration_s = 4000\narena.robots = 8\n");
  const std::string out = (bench.folder.path() / "out").string();
  const std::vector<std::string> words = {"batch", file.string(), "--out", out, "--index", "1"};
  tests::Process first = bench.start(words);
  REQUIRE(tests::eventually(300s, [&] { return fs::exists(fs::path(out) / "runs/00001/result.json"); }));
  first.signal(SIGSTOP);
  const auto [code, said] = bench.run(words);
  CHECK(code == 2);
  CHECK(said.find("run 1 is in progress in another process") != std::string::npos);
  first.signal(SIGCONT);
  CHECK(first.wait(300s) == 0);
}

TEST_CASE("a run is repeated from its folder alone, also from a copy, and a difference is told") {
  BatchBench bench;
  const fs::path file = bench.file(small_labs + "seeds = \"1..2\"\n[set]\nrun.duration_s = 40\narena.robots = 8\n");
  REQUIRE(bench.batch(file, "out").first == 0);
  const fs::path out = bench.folder.path() / "out", copy = bench.folder.path() / "elsewhere/run";
  const auto rerun = [&](const fs::path& what, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"rerun", what.string()};
    words.insert(words.end(), more.begin(), more.end());
    return bench.run(words);
  };
  const auto equal = rerun(out / "manifest.json", {"--index", "1"});
  CAPTURE(equal.second);
  CHECK(equal.first == 0);
  CHECK(equal.second.find("equal: final hash ") != std::string::npos);
  fs::create_directories(copy.parent_path());
  fs::copy(out / "runs/00001", copy, fs::copy_options::recursive);
  fs::remove_all(out / "runs/00001");
  CHECK(rerun(copy).first == 0);
  CHECK(rerun(copy / "result.json").first == 0);
  CHECK(rerun(copy / "shark/config.toml").first == 0);
  // another seed is another run
  std::string config = tests::read_file(copy / "shark/config.toml");
  const std::size_t seed = config.find("seed = 2");
  REQUIRE(seed != std::string::npos);
  config.replace(seed, 8, "seed = 3");
  std::ofstream(copy / "shark/config.toml") << config;
  const auto different = rerun(copy);
  CAPTURE(different.second);
  CHECK(different.first == 1);
  CHECK(different.second.find("has changed since the run") != std::string::npos);
  CHECK(different.second.find("different: final hash ") != std::string::npos);
  CHECK(different.second.find("the first difference is in period ") != std::string::npos);
  // what cannot be repeated
  CHECK(rerun(copy, {"--out", copy.string()}).second.find("give an empty or new folder") != std::string::npos);
  CHECK(rerun(out).second.find("choose one of its runs with --index") != std::string::npos);
  CHECK(rerun(out, {"--index", "7"}).second.find("holds no result.json") != std::string::npos);
  fs::remove(copy / "shark/config.toml");
  CHECK(rerun(copy).second.find("the folders of all its labs") != std::string::npos);
  CHECK(rerun(file).second.find("is neither a run's folder") != std::string::npos);
}

TEST_CASE("a robot's program is proved with what that robot got in a recorded run") {
  if (!fs::exists("/usr/include/simavr/sim_avr.h")) {
    MESSAGE("simavr is not installed: nothing is proved");
    return;
  }
  BatchBench bench;
  const std::string root = ARKMESH_SOURCE_DIR;
  const fs::path file = bench.file(fmt::format(
      "labs = ['{0}/experiments/dhtf/shark.toml', '{0}/experiments/dhtf/roark.toml']\nseeds = 1\n[set]\n"
      "run.duration_s = 20\narena.robots = 4\n'roark:arena.ode.controller' = '{0}/tests/programs/differs/fraction.c'\n",
      root));
  REQUIRE(bench.batch(file, "out").first == 0);
  const std::string run = (bench.folder.path() / "out/runs/00000").string();
  const auto prove = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"controller", "prove", "--run", run};
    words.insert(words.end(), more.begin(), more.end());
    return bench.run(words);
  };
  const auto same = prove({"--lab", "shark", "--robot", "3"});
  CAPTURE(same.second);
  CHECK(same.first == 0);
  CHECK(same.second.find("every output is the same on robot 3 of lab shark") != std::string::npos);
  const auto different = prove({"--lab", "roark", "--robot", "1"});
  CAPTURE(different.second);
  CHECK(different.first == 1);
  CHECK(different.second.find("robot 1, tick ") != std::string::npos);
  CHECK(different.second.find("level is 7 on a robot and 8 here") != std::string::npos);
  CHECK(prove({"--robot", "3"}).second.find("choose one of the run's labs: ") != std::string::npos);
  const auto nobody = prove({"--lab", "shark", "--robot", "4"});
  CHECK(nobody.first == 2);
  CHECK(nobody.second.find("lab shark has the robots 0 to 3") != std::string::npos);
}
