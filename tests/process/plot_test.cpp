// `arkmesh plot`: a run at a moment, and curves of several runs, of seeds and of batches, which keep no logs.
#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/process/batch_bench.hpp"
#include "tests/support/processes/process.hpp"

using namespace arkmesh;
namespace fs = std::filesystem;

// CRE's swarms are counted in each period, whatever robots do.
#define CRE ARKMESH_SOURCE_DIR "/experiments/cre/"

namespace {

struct PlotBench : tests::BatchBench {
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  void make_run(const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"run",   CRE "meadow.toml",   CRE "sky.toml", "--set",   "arena.use=null",
                                      "--set", "run.duration_s=10", "--out",        path(name)};
    words.insert(words.end(), more.begin(), more.end());
    const auto done = run(words);
    REQUIRE_MESSAGE(done.first == 0, done.second);
  }
  // That picture was made, and said so.
  void draws(std::vector<std::string> words, const std::string& picture) {
    words.insert(words.begin(), "plot");
    const auto done = run(words);
    const std::string& output = done.second;
    CHECK_MESSAGE(done.first == 0, output);
    CHECK_MESSAGE(output.find("wrote " + path(picture)) != std::string::npos, output);
    CHECK(tests::read_file(path(picture)).starts_with("\x89PNG"));
    fs::remove(path(picture));
  }
  // Refused, in one sentence.
  void refuses(std::vector<std::string> words, const std::string& why) {
    words.insert(words.begin(), "plot");
    const auto done = run(words);
    const std::string& output = done.second;
    CHECK_MESSAGE(done.first != 0, output);
    CHECK_MESSAGE(output.find(why) != std::string::npos, output);
    CHECK_MESSAGE(output.find("Traceback") == std::string::npos, output);
  }
};

}  // namespace

TEST_CASE("plot draws a run at a moment, and several runs as curves") {
  PlotBench bench;
  bench.make_run("one");
  bench.make_run("two", {"--set", "run.seed=2"});
  bench.make_run("packed", {"--set", "recorder.compress=true"});
  CHECK(fs::exists(bench.path("packed/sky/log.lcm.zst")));
  CHECK_FALSE(fs::exists(bench.path("packed/sky/log.lcm")));
  bench.draws({bench.path("packed")}, "packed/picture.png");
  bench.draws({bench.path("one"), "--at", "4", "--out", bench.path("at.png")}, "at.png");
  bench.draws({bench.path("one"), bench.path("two")}, "one/curves.png");
  bench.refuses({bench.path("one"), "--series", "dances"}, "no run has dances; there are swarms.uncommitted");
  for (const char* lab : {"meadow", "sky"}) fs::remove(bench.path("two/" + std::string(lab) + "/log.lcm"));
  bench.draws({bench.path("two")}, "two/curves.png");  // of its tables
}

TEST_CASE("plot draws batches as curves, also where they keep no logs") {
  PlotBench bench;
  const auto study = bench.file("labs = [\"" CRE "meadow.toml\", \"" CRE
                                "sky.toml\"]\n"
                                "seeds = \"1..2\"\n[set]\narena.use = \"null\"\nrun.duration_s = 10\n[sweep]\n"
                                "gate.period_s = [1, 2]\n");
  const auto made = bench.batch(study, "batch");
  REQUIRE_MESSAGE(made.first == 0, made.second);
  REQUIRE(fs::exists(bench.path("batch/runs.csv")));
  bench.draws({bench.path("batch")}, "batch/curves.png");
  bench.draws({bench.path("batch"), "--by", "gate.period_s", "--series", "swarms.north"}, "batch/curves.png");
  bench.refuses({bench.path("batch"), "--at", "4"}, "--at needs a single run");
  bench.refuses({bench.path("batch"), "--by", "colour"}, "has no factor colour; it has gate.period_s");
}

TEST_CASE("plot says what a folder lacks") {
  PlotBench bench;
  fs::create_directories(bench.path("empty"));
  bench.refuses({bench.path("empty")}, "is neither a run nor a batch");
  bench.refuses({bench.path("nowhere")}, "Directory does not exist");
  fs::create_directories(bench.path("cut/shark"));
  bench.file("not a log", "cut/shark/log.lcm");
  bench.refuses({bench.path("cut")}, "log.lcm is not an LCM log");
}
