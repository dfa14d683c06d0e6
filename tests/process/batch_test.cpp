// `arkmesh batch` as processes: the same tables however it is run, killed and stopped; runs that fail; a full disk.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/process/batch_bench.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using tests::BatchBench, tests::rows, tests::small_batch, tests::small_labs;
namespace fs = std::filesystem;

namespace {

// All tables of a batch as one text.
std::string tables(const BatchBench& bench, const std::string& out) {
  return bench.table(out) + bench.table(out, "counters.csv") + bench.table(out, "summary.csv") +
         bench.table(out, "effects.csv");
}

// When each finished run's result was written, in nanoseconds.
std::map<std::string, std::int64_t> results(const fs::path& batch) {
  std::map<std::string, std::int64_t> out;
  std::error_code error;
  for (fs::directory_iterator run(batch / "runs", error), end; !error && run != end; run.increment(error)) {
    const fs::path file = run->path() / "result.json";
    const auto result = nlohmann::json::parse(tests::read_file(file), nullptr, false);
    struct stat about {};
    if (result.is_object() && result.value("state", "") == "finished" && ::stat(file.c_str(), &about) == 0)
      out[run->path().filename()] = about.st_mtim.tv_sec * 1'000'000'000 + about.st_mtim.tv_nsec;
  }
  return out;
}

// A run of the batch has begun and has no result yet.
bool in_the_midst(const fs::path& out) {
  std::error_code ignored;
  const auto done = results(out);
  for (const auto& run : fs::directory_iterator(out / "runs", ignored))
    if (!done.contains(run.path().filename())) return true;
  return false;
}

}  // namespace

TEST_CASE("a batch of labs' files has a run for each seed, the same as arkmesh run does, and goes on") {
  BatchBench bench;
  const fs::path out = bench.folder.path() / "seeds", alone = bench.folder.path() / "alone";
  const auto run = [&](const std::string& command, const fs::path& folder, const std::vector<std::string>& more) {
    std::vector<std::string> words = {command,
                                      ARKMESH_SOURCE_DIR "/experiments/dhtf/shark.toml",
                                      ARKMESH_SOURCE_DIR "/experiments/dhtf/roark.toml",
                                      "--out",
                                      folder.string(),
                                      "--set",
                                      "run.duration_s=10",
                                      "--set",
                                      "arena.robots=2"};
    words.insert(words.end(), more.begin(), more.end());
    const auto [code, said] = bench.run(words);
    CHECK_MESSAGE(code == 0, said);
    return said;
  };
  const auto hash = [](const fs::path& folder) {
    return nlohmann::json::parse(tests::read_file(folder / "result.json")).at("final_hash").get<std::string>();
  };
  CHECK(run("batch", out, {"--seeds", "3..4", "--jobs", "2"}).find("2 of 2 runs finished") != std::string::npos);
  run("run", alone, {"--seed", "4"});
  CHECK(hash(out / "runs/00001") == hash(alone));
  CHECK(hash(out / "runs/00001") != hash(out / "runs/00000"));
  CHECK_FALSE(fs::exists(out / "runs/00001/shark/log.lcm"));
  CHECK(fs::exists(alone / "shark/log.lcm"));
  const auto before = results(out);
  run("batch", out, {"--seeds", "3..4"});
  CHECK(before.size() == 2);
  CHECK(results(out) == before);
}

TEST_CASE("a batch gives the same tables on one job, on two, run by run, and a run alone its row") {
  BatchBench bench;
  const fs::path file = bench.file(small_batch);
  const auto [code, words] = bench.batch(file, "one", {"--jobs", "1"});
  const std::string said = words;
  CAPTURE(said);
  REQUIRE(code == 0);
  CHECK(said.find("16 of 16 runs finished, 0 failed") != std::string::npos);
  CHECK(rows(bench.table("one")) == 16);
  CHECK(bench.table("one").find("run,setting,gate.period_s,scenario.dhtf.types,seed,state,why,final_hash,completed") ==
        0);
  CHECK(bench.batch(file, "two", {"--jobs", "2"}).first == 0);
  CHECK(tables(bench, "one") == tables(bench, "two"));
  for (int run = 15; run >= 0; --run) REQUIRE(bench.batch(file, "single", {"--index", std::to_string(run)}).first == 0);
  CHECK(bench.table("single").empty());
  CHECK(bench.batch(file, "single", {"--gather"}).first == 0);
  CHECK(tables(bench, "one") == tables(bench, "single"));
  CHECK(bench.batch(file, "single", {"--index", "3"}).second.find("already has a result") != std::string::npos);
  // nothing is left to do, and nothing is done
  const auto before = results(bench.folder.path() / "one");
  CHECK(bench.batch(file, "one").first == 0);
  CHECK(results(bench.folder.path() / "one") == before);
}

TEST_CASE("a batch that is killed at any moment goes on to the same tables, and no run is done twice") {
  BatchBench bench;
  const fs::path file = bench.file(small_batch), out = bench.folder.path() / "killed";
  REQUIRE(bench.batch(file, "whole", {"--jobs", "2"}).first == 0);
  std::mt19937 random(17);
  std::map<std::string, std::int64_t> seen;
  bool half_written = false;
  int kills = 0;
  while (seen.size() < 16 && kills < 60) {
    tests::Process batch = bench.start({"batch", file.string(), "--out", out.string(), "--jobs", "2"});
    // at least until there is one more, so that this ends; then at once while a run is in the midst, or some
    // milliseconds later
    tests::eventually(300s, [&] { return results(out).size() > seen.size() || !batch.running(); });
    if (kills++ % 2 == 0)
      tests::eventually(300s, [&] { return in_the_midst(out) || !batch.running(); });
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 50));
    batch.kill();
    const auto now = results(out);
    for (const auto& [number, written] : seen) {
      const auto run = number;
      CAPTURE(run);
      REQUIRE(now.contains(run));
      CHECK(now.at(run) == written);  // as it was: neither lost nor done again
    }
    half_written = half_written || in_the_midst(out);
    seen = now;
  }
  CAPTURE(kills);
  CHECK(half_written);
  CHECK(bench.batch(file, "killed").first == 0);
  CHECK(tables(bench, "killed") == tables(bench, "whole"));
}

TEST_CASE("a batch that the operator stops ends with exit code 3, says what is left, and goes on") {
  BatchBench bench;
  const fs::path file = bench.file(small_batch + "\n[choices.long.run]\nrun.patience = 1\n");
  CHECK(bench.batch(file, "refused").first == 2);
  const fs::path slow =
      bench.file(small_labs + "seeds = \"1..4\"\n[set]\nrun.duration_s = 4000\narena.robots = 8\n", "slow.toml");
  tests::Process batch =
      bench.start({"batch", slow.string(), "--out", (bench.folder.path() / "slow").string(), "--jobs", "1"});
  REQUIRE(tests::eventually(300s, [&] { return fs::exists(bench.folder.path() / "slow/runs/00000/result.json"); }));
  batch.signal(SIGTERM);
  CHECK(batch.wait(300s) == 3);
  const std::string said = batch.output();
  CAPTURE(said);
  CHECK(said.find("repeat the command to resume them") != std::string::npos);
  CHECK(bench.batch(slow, "slow").first == 0);
  CHECK(rows(bench.table("slow")) == 4);
}

TEST_CASE("a run that fails is a row that says why, and the others go on") {
  BatchBench bench;
  const fs::path file =
      bench.file(small_labs +
                 "seeds = [1, 2]\n[set]\nrun.duration_s = 20\narena.robots = 8\n[choices.program.good]\n"
                 "[choices.program.crashes]\narena.ode.controller = \"" ARKMESH_SOURCE_DIR
                 "/tests/programs/crash_after_delay.c\"\n");
  const auto [code, words] = bench.batch(file, "out");
  const std::string said = words;
  CAPTURE(said);
  CHECK(code == 1);
  CHECK(said.find("2 of 4 runs finished, 2 failed") != std::string::npos);
  CHECK(said.find("run 2 (seed 1) did not finish: ") != std::string::npos);
  const std::string table = bench.table("out");
  CAPTURE(table);
  CHECK(rows(table) == 4);
  CHECK(table.find("\n2,1,crashes,1,failed,") != std::string::npos);
  CHECK(table.find("robot 2") != std::string::npos);
  // failed runs are done again only on demand, and fail again
  const auto result = [&] { return fs::last_write_time(bench.folder.path() / "out/runs/00002/result.json"); };
  const auto first = result();
  CHECK(bench.batch(file, "out").first == 1);
  CHECK(result() == first);
  CHECK(bench.batch(file, "out", {"--retry"}).first == 1);
  CHECK(result() > first);
  CHECK(bench.table("out") == table);
}

TEST_CASE("a run whose process is killed is still to be done, the others go on, and the same command does it") {
  // As the kernel kills it when the memory is full. The table is that of a batch in which nobody was killed.
  BatchBench bench;
  const fs::path file = bench.file(small_labs + "seeds = \"1..3\"\n[set]\nrun.duration_s = 4000\narena.robots = 8\n");
  const fs::path out = bench.folder.path() / "out";
  tests::Process batch = bench.start({"batch", file.string(), "--out", out.string(), "--jobs", "1"});
  int victim = 0;
  REQUIRE(tests::eventually(300s, [&] {
    const auto result = nlohmann::json::parse(tests::read_file(out / "runs/00001/result.json"), nullptr, false);
    if (result.is_object() && result.value("state", "") == "running") victim = result.at("process").at("pid");
    return victim > 0;
  }));
  ::kill(victim, SIGKILL);
  CHECK(batch.wait(300s) == 1);
  const std::string said = batch.output();
  CAPTURE(said);
  CHECK(said.find("run 1 (seed 2) did not finish: its process was killed") != std::string::npos);
  CHECK(said.find("1 run is unfinished; repeat the command to resume it") != std::string::npos);
  CHECK(said.find("2 of 3 runs finished, 0 failed") != std::string::npos);
  CHECK(nlohmann::json::parse(tests::read_file(out / "runs/00001/result.json")).at("state") == "killed");
  CHECK(rows(bench.table("out")) == 2);
  const auto before = results(out);
  CHECK(bench.batch(file, "out").first == 0);
  CHECK(rows(bench.table("out")) == 3);
  for (const auto& [number, written] : before) CHECK(results(out).at(number) == written);
  CHECK(bench.batch(file, "whole").first == 0);
  CHECK(tables(bench, "out") == tables(bench, "whole"));
}

TEST_CASE("a full disk stops a batch in plain words, and loses no finished run") {
  BatchBench bench;
  const std::string disk = (bench.folder.path() / "disk").string();
  fs::create_directory(disk);
  const fs::path file = bench.file(small_batch + "[choices.a.b]\nrecorder.keep_free_mib = 0\n"),
                 kept = bench.folder.path() / "kept";
  // A file system of 8 MiB in a name space of our own. Once it has room for some runs only, once it is filled to the
  // last byte in the midst of a run; then there is room again.
  const std::string script =
      "mount -t tmpfs -o size=8m none {0}\n"
      "run() {{ {1} batch {2} --out {0}/out --jobs 1; echo code $?; }}\n"
      "dd if=/dev/zero of={0}/ballast bs=64k count=93 2>/dev/null; run; rm {0}/ballast\n"
      "echo half way; before=$(ls {0}/out/runs | wc -l); run & \n"
      "while [ $(ls {0}/out/runs | wc -l) -lt $((before + 2)) ]; do sleep 0.01; done\n"
      "dd if=/dev/zero of={0}/ballast bs=4k 2>/dev/null; wait; rm {0}/ballast; echo room; run; cp -r {0}/out {3}\n";
  const fs::path commands = bench.folder.write(
      "commands.sh", fmt::format(fmt::runtime(script), disk, ARKMESH_PROGRAM, file.string(), kept.string()));
  tests::Process shell("/bin/sh", {"-c", "exec unshare -m sh " + commands.string()}, bench.folder.path() / "shell.txt");
  REQUIRE(shell.wait(300s) == 0);
  const std::string said = shell.output();
  CAPTURE(said);
  const std::size_t half = said.find("half way"), room = said.find("room\n");
  REQUIRE(half < room);
  REQUIRE(room != std::string::npos);
  for (const std::string& part : {said.substr(0, half), said.substr(half, room - half)}) {
    CAPTURE(part);
    CHECK(part.find("code 1") != std::string::npos);
    CHECK(part.find("the disk of ") != std::string::npos);
    CHECK(part.find("runs are unfinished; repeat the command to resume them") != std::string::npos);
  }
  const std::size_t some = said.find(" of 16 runs finished, 0 failed");
  REQUIRE(some < half);
  CHECK(std::stoi(said.substr(said.rfind('\n', some) + 1)) > 0);
  CHECK(said.find("16 of 16 runs finished, 0 failed", room) != std::string::npos);
  CHECK(said.find("code 0", room) != std::string::npos);
  REQUIRE(bench.batch(file, "whole").first == 0);
  CHECK(tests::read_file(kept / "runs.csv") == bench.table("whole"));
}
