// `arkmesh run`: several labs in one process, for one seed or a batch of seeds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "app/batch_plan.hpp"
#include "app/batch_results.hpp"
#include "app/joint_run.hpp"
#include "app/lab_check.hpp"
#include "app/run_pool.hpp"
#include "cli/commands.hpp"
#include "cli/count_words.hpp"
#include "cli/operator_stop.hpp"
#include "cli/page_opener.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "hal/replace_file.hpp"
#include "hal/result_file.hpp"
#include "lab/run_folder.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;

struct RunOptions {
  app::LabFiles labs;
  std::string seeds, out;
  std::int64_t seed = -1;
  int jobs = 1;
  bool force = false, open = false;
};

std::filesystem::path directory_of(const RunOptions& options) {
  if (!options.out.empty()) return options.out;
  std::string names;
  for (const hal::Config& lab : app::read_labs(options.labs, options.seed))
    names += (names.empty() ? "" : "-") + lab.root().section("lab").get("name", std::string());
  return lab::default_run_directory(names);
}

int run_once(const RunOptions& options, const std::filesystem::path& directory, OperatorStop& stop) {
  using Folder = app::JointRun::Folder;
  app::JointRun run(app::read_labs(options.labs, options.seed), directory,
                    options.force ? Folder::moved_aside : Folder::must_be_empty, {}, true);
  ProgressLine progress(run.names());
  if (run.page() && options.open) show_page(run.page()->url(), directory, true);
  // A run that is over in a moment takes its page with it.
  if (run.page() && !options.open) progress.say_after(2s, page_words(run.page()->url()));
  const nlohmann::json result = run.run(stop, &progress);
  if (!run.finished()) {
    progress.say(fmt::format("arkmesh: run of {} ended early: {}", run.names(), hal::ended_in(result)));
    return exit_code(hal::outcome_in(result).value_or(hal::Outcome::failed));
  }
  const nlohmann::json& wall = result.at("wall");
  fmt::print("{}, seed {}: {:.0f} s simulated in {:.1f} s ({:.0f}x), final hash {}\n", run.names(),
             result.at("seed").get<std::uint64_t>(), result.at("duration_s").get<double>(),
             wall.at("total_s").get<double>(), wall.at("speed").get<double>(),
             result.at("final_hash").get<std::string>());
  for (const auto& [name, n] : result.at("counts").items())
    fmt::print("  {}\n", count_words(name, n.get<std::uint64_t>()));
  fmt::print("  results in {0}\n  see it with arkmesh view {0}\n", directory.string());
  return 0;
}

std::vector<std::int64_t> parse_seeds(const std::string& text) try {
  if (text.find("..") == std::string::npos) throw std::invalid_argument("no range");
  return app::seeds_of({text});
} catch (const std::invalid_argument&) {
  throw hal::ConfigError(
      fmt::format("--seeds {}: must be FIRST..LAST with 0 <= FIRST <= LAST, for example 1..20", text));
}

// A row for each seed that has a result, in the order of seeds.
void save_seeds(const std::vector<app::RunTask>& tasks, const std::filesystem::path& file) {
  std::vector<app::BatchRow> rows;
  for (const app::RunTask& task : tasks)
    if (app::BatchRow row{.run = task.number, .seed = task.seed}; app::read_row(task.directory, row))
      rows.push_back(std::move(row));
  hal::must_replace_file(file, app::seeds_table(rows));
}

int run_batch(const RunOptions& options, const std::filesystem::path& directory, OperatorStop& stop) {
  const std::vector<std::int64_t> seeds = parse_seeds(options.seeds);
  app::check_labs(app::read_labs(options.labs, seeds.front()));
  lab::claim_run_folder(directory, options.force);
  std::vector<app::RunTask> tasks;
  for (const std::int64_t seed : seeds)
    tasks.push_back({.number = tasks.size(),
                     .labs = options.labs,
                     .seed = seed,
                     .directory = directory / fmt::format("seed-{}", seed)});
  app::RunPool pool({tasks.begin(), tasks.end()}, static_cast<std::size_t>(options.jobs), 0);
  std::size_t failed = 0, done = 0;
  while (!pool.done()) {
    const auto ended = pool.next(stop, 200ms);
    if (!ended) continue;
    failed += ended->finished ? 0 : 1;
    fmt::print(stderr, "{}seed {} {}  ({}/{})\n", ended->said, tasks[ended->number].seed,
               ended->finished ? "done" : "failed", ++done, tasks.size());
  }
  const std::filesystem::path table = directory / "seeds.csv";
  save_seeds(tasks, table);
  fmt::print("{} runs, {} failed; table in {}\n", tasks.size(), failed, table.string());
  return exit_code(stop.stopped()                  ? hal::Outcome::stopped
                   : failed == 0 && !pool.halted() ? hal::Outcome::finished
                                                   : hal::Outcome::failed);
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
  command->add_flag("--open", options->open, "Open the page of the labs in a browser; a batch has none");
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
