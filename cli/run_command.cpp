// `arkmesh run`: several labs in one process, for one seed or a batch of seeds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/batch.hpp"
#include "app/joint_run.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "lab/run_folder.hpp"

namespace arkmesh::cli {
namespace {

struct RunOptions {
  app::LabFiles labs;
  std::string seeds, out;
  std::int64_t seed = -1;
  int jobs = 1;
  bool force = false;
};

std::filesystem::path directory_of(const RunOptions& options) {
  if (!options.out.empty()) return options.out;
  std::string names;
  for (const hal::Config& lab : app::read_labs(options.labs, options.seed))
    names += (names.empty() ? "" : "-") + lab.root().section("lab").get("name", std::string());
  return lab::default_run_directory(names);
}

int run_once(const RunOptions& options, const std::filesystem::path& directory, OperatorStop& stop) {
  app::JointRun run(app::read_labs(options.labs, options.seed), directory, options.force);
  ProgressLine progress(run.names());
  const nlohmann::json result = run.run(stop, &progress);
  if (!run.finished()) {
    progress.say(fmt::format("arkmesh: run of {} ended early: {}", run.names(), result.at("ended").get<std::string>()));
    return exit_code(result.at("state").get<std::string>());
  }
  const nlohmann::json& wall = result.at("wall");
  fmt::print("{}, seed {}: {:.0f} s simulated in {:.1f} s ({:.0f}x), final hash {}\n", run.names(),
             result.at("seed").get<std::uint64_t>(), result.at("duration_s").get<double>(),
             wall.at("total_s").get<double>(), wall.at("speed").get<double>(),
             result.at("final_hash").get<std::string>());
  for (const auto& [name, n] : result.at("counts").items()) fmt::print("  {}: {}\n", name, n.get<std::uint64_t>());
  fmt::print("  results in {}\n", directory.string());
  return 0;
}

std::pair<std::int64_t, std::int64_t> parse_seeds(const std::string& text) {
  std::int64_t first = -1, last = -1;
  int used = 0;
  if (std::sscanf(text.c_str(), "%ld..%ld%n", &first, &last, &used) != 2 || used != static_cast<int>(text.size()) ||
      first < 0 || last < first)
    throw hal::ConfigError(
        fmt::format("--seeds {}: must be FIRST..LAST with 0 <= FIRST <= LAST, for example 1..20", text));
  return {first, last};
}

int run_batch(const RunOptions& options, const std::filesystem::path& directory, OperatorStop& stop) {
  const auto [first, last] = parse_seeds(options.seeds);
  app::Batch batch(options.labs, first, last, options.jobs, directory, options.force);
  int failed = 0;
  std::int64_t done = 0;
  while (const auto ended = batch.next(stop)) {
    failed += ended->good ? 0 : 1;
    fmt::print(stderr, "seed {} {}  ({}/{})\n", ended->seed, ended->good ? "done" : "failed", ++done, last - first + 1);
  }
  batch.save_table();
  fmt::print("{} runs, {} failed; table in {}\n", last - first + 1, failed, batch.table().string());
  return exit_code(stop.stopped() ? "stopped" : failed == 0 ? "finished" : "failed");
}

int run(const RunOptions& options) {
  OperatorStop stop;
  const std::filesystem::path directory = directory_of(options);
  return options.seeds.empty() ? run_once(options, directory, stop) : run_batch(options, directory, stop);
}

}  // namespace

void add_run_command(CLI::App& app) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = add_command(app, "run");
  command->add_option("files", options->labs.files, "A configuration file for each lab")
      ->required()
      ->check(CLI::ExistingFile);
  auto* seed = command->add_option("--seed", options->seed, "Seed of all labs (overrides run.seed)")
                   ->check(CLI::NonNegativeNumber);
  command->add_option("--seeds", options->seeds, "A batch, one run per seed: FIRST..LAST")->excludes(seed);
  command->add_option("--jobs", options->jobs, "How many runs of a batch at a time")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for the results, empty or new (default runs/DATE-TIME-LABS)");
  command->add_flag("--force", options->force, "Move what the folder holds aside, to OUT.1");
  command
      ->add_option("--set", options->labs.sets,
                   "Override a key of every lab, or of one: --set gate.slack=1, --set shark:arena.robots=30")
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh run experiments/dhtf/shark.toml experiments/dhtf/roark.toml --seed 7 --set "
      "run.duration_s=600\n"
      "The labs of the shared world are those given; shared.labs of the files is not used unless --set says so.");
  command->callback([options] {
    hand_over_cameras(options->labs.files, options->labs.sets);
    if (const int code = run(*options); code != 0) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
