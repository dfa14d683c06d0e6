// `arkmesh batch`: a grid of settings and seeds, run on all cores, or one run at a time where a cluster asks for it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "app/batch/batch.hpp"
#include "app/batch/batch_plots.hpp"
#include "app/batch/batch_progress.hpp"
#include "app/batch/batch_results.hpp"
#include "app/batch/slurm_array.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "hal/counted.hpp"
#include "hal/record/result_file.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;

struct BatchOptions {
  app::Batch::Request request;
  app::BatchPlot plot;
  std::vector<std::string> slurm_options;
  std::int64_t run = -1;
  int jobs = 0;
  bool gather = false, retry = false, slurm = false, list = false;
};

std::size_t jobs_of(const BatchOptions& options) {
  return options.jobs > 0 ? static_cast<std::size_t>(options.jobs) : std::max(1U, std::thread::hardware_concurrency());
}

void list_runs(const app::BatchPlan& plan) {
  for (std::size_t setting = 0; setting < plan.settings(); ++setting)
    fmt::print("runs {}..{}: {}\n", setting * plan.seeds.size(), (setting + 1) * plan.seeds.size() - 1,
               plan.factors.empty() ? "the labs' own settings" : plan.name_of(setting));
  fmt::print("{} x {} = {}\n", hal::counted(plan.settings(), "setting"), hal::counted(plan.seeds.size(), "seed"),
             hal::counted(plan.runs(), "run"));
}

// Runs and tables are what counts: a figure may be about something that no run reached.
void draw_plots(const app::Batch& batch) {
  for (const app::BatchPlot& plot : batch.plan().plots) {
    try {
      app::draw_batch(batch.directory(), plot);
    } catch (const std::runtime_error& why) {
      fmt::print(stderr, "arkmesh: cannot draw {}: {}\n", plot.column, why.what());
    }
  }
}

// Tables of what there is, and the experiment's figures when all runs have ended. Returns the exit code.
int gather(const app::Batch& batch, const std::string& why_halted) {
  const app::BatchResults results(batch.plan(), batch.directory());
  const std::size_t all = batch.plan().runs(), ended = results.rows().size(), finished = results.finished();
  // first of all: on a full disk there may be no tables
  if (ended < all)
    fmt::print(stderr, "arkmesh: {}{} unfinished; repeat the command to resume {}\n",
               why_halted.empty() ? "" : why_halted + "; ", hal::counted(all - ended, "run is", "runs are"),
               all - ended == 1 ? "it" : "them");
  results.save();
  fmt::print("{} of {} finished, {} failed; tables in {}\n", finished, hal::counted(all, "run"), ended - finished,
             batch.directory().string());
  if (ended < all) return why_halted == "stopped" ? 3 : 1;
  draw_plots(batch);
  return finished == all ? 0 : 1;
}

int run_all(const BatchOptions& options, app::Batch& batch, OperatorStop& stop, ProgressLine& line) {
  for (const hal::Config& lab : app::read_labs(batch.plan().labs_of(0), batch.plan().seeds.front()))
    for (const std::string& absent : lab.root().section("shared").get("absent", std::vector<std::string>()))
      line.say(fmt::format("{} of shared.labs does not take part beside {}", absent,
                           lab.root().section("lab").get("name", std::string())));
  const std::vector<std::size_t> open = batch.open_runs(options.retry);
  std::deque<app::RunTask> tasks;
  for (const std::size_t run : open) tasks.push_back(batch.task(run));
  app::BatchProgress progress(line, batch.plan().runs(), open.size());
  bool checked = batch.plan().plots.empty();
  app::RunPool pool(std::move(tasks), jobs_of(options), batch.free_bytes(jobs_of(options)));
  while (!pool.done()) {
    if (const auto ended = pool.next(stop, 200ms)) {
      progress.ended(*ended, batch.task(ended->number));
      if (ended->finished && !std::exchange(checked, true))
        app::BatchResults(batch.plan(), batch.directory()).check_plots();
    }
    progress.show(pool.running());
  }
  line.done();
  return gather(batch, pool.why_halted());
}

int run_one(app::Batch& batch, std::size_t run, bool retry, OperatorStop& stop) {
  if (!batch.take_run(run))
    throw hal::ConfigError(fmt::format("run {} is in progress in another process; wait until it ends", run));
  const app::RunState state = batch.state_of(run);
  if (state == app::RunState::finished || (state == app::RunState::failed && !retry)) {
    fmt::print("run {} already has a result\n", run);
    return 0;
  }
  const app::RunTask task = batch.task(run);
  if (const std::string other = hal::ResultFile(task.directory).goes_on_in_words(); !other.empty())
    throw hal::ConfigError(fmt::format("run {}: {} is the folder of {}", run, task.directory.string(), other));
  return app::run_task(task, stop);
}

void hand_over(const app::BatchPlan& plan) {
  std::vector<std::string> sets = plan.labs.sets;
  hand_over_cameras(plan.labs.files, sets);
  for (const app::Factor& factor : plan.factors)
    for (const app::Factor::Level& level : factor.levels) {
      // few of a large grid's levels say which arena a lab has
      if (std::ranges::none_of(level.sets, [](const std::string& set) {
            return set.find("arena") != set.npos && set.find("use") != set.npos;
          }))
        continue;
      std::vector<std::string> all = sets;
      all.insert(all.end(), level.sets.begin(), level.sets.end());
      hand_over_cameras(plan.labs.files, all);
    }
}

app::BatchFolder::Use use_of(const BatchOptions& options) {
  using Use = app::BatchFolder::Use;
  if (options.gather || !options.plot.column.empty()) return Use::looking;
  return options.slurm || options.run >= 0 ? Use::single_runs : Use::alone;
}

int run(const BatchOptions& options) {
  app::Batch batch(options.request);
  hand_over(batch.plan());
  if (options.list) return list_runs(batch.plan()), 0;
  if (options.run >= static_cast<std::int64_t>(batch.plan().runs()))
    throw hal::ConfigError(fmt::format("--index {}: the batch has runs 0..{}", options.run, batch.plan().runs() - 1));
  OperatorStop stop;
  ProgressLine line;
  const bool single = options.run >= 0;
  batch.begin(use_of(options), single ? std::optional<std::size_t>(options.run) : std::nullopt, line);
  if (single) return run_one(batch, static_cast<std::size_t>(options.run), options.retry, stop);
  std::string why_halted;
  int code = 0;
  if (options.slurm)
    why_halted = app::run_on_slurm(batch, {options.request, options.slurm_options, options.retry}, stop, line);
  else if (!options.gather && options.plot.column.empty())
    code = run_all(options, batch, stop, line);
  if (options.slurm || options.gather) code = gather(batch, why_halted);
  if (!options.plot.column.empty()) app::draw_batch(batch.directory(), options.plot);
  return code;
}

}  // namespace

void add_batch_command(CLI::App* command) {
  auto options = std::make_shared<BatchOptions>();
  command->add_option("files", options->request.files, "An experiment file, or a configuration file for each lab")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--jobs", options->jobs, "Number of parallel runs (default: one per core)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--out", options->request.out, "Folder of the batch (default runs/FOLDER-NAME of the files)");
  command->add_option("--seeds", options->request.seeds, "Seeds in place of the experiment's: FIRST..LAST");
  command->add_option("--set", options->request.sets, "Override a key of every lab, or of one, in all runs")
      ->allow_extra_args(false);
  auto* index = command->add_option("--index", options->run, "Perform this run only, without tables")
                    ->check(CLI::Range(std::int64_t{0}, static_cast<std::int64_t>(app::max_batch_runs) - 1));
  auto* slurm = command->add_flag("--slurm", options->slurm, "Submit the runs as a Slurm job array, and wait for it")
                    ->excludes(index);
  command->add_option("--slurm-option", options->slurm_options, "Passed to sbatch: --slurm-option=--partition=long")
      ->needs(slurm)
      ->allow_extra_args(false);
  command->add_flag("--gather", options->gather, "Write the tables of finished runs; start none")
      ->excludes(index)
      ->excludes(slurm);
  command->add_flag("--retry", options->retry, "Repeat failed runs");
  command->add_flag("--list", options->list, "List the runs; start none");
  auto* plot = command->add_option("--plot", options->plot.column, "Draw this column of the table; start no runs");
  auto* over =
      command->add_option("--over", options->plot.over, "Key or choice along the horizontal axis")->needs(plot);
  plot->needs(over)->excludes(index)->excludes(slurm);
  command->add_option("--by", options->plot.by, "Draw a line or a group of boxes for each value of this key or choice")
      ->needs(plot);
  command->add_option("--kind", options->plot.kind, "box or line (default: depends on the key)")->needs(plot);
  for (CLI::Option* look : add_looks(command, options->plot.looks)) look->needs(plot);
  command->footer(
      "Examples:\n  arkmesh batch experiments/dhtf/batch.toml\n  arkmesh batch study.toml --seeds 1..5 --out runs/try\n"
      "  arkmesh batch shark.toml roark.toml --seeds 1..20\n"
      "  arkmesh batch study.toml --plot completed --over gate.period_s\n"
      "Repeat the command to resume a batch that was stopped or killed.");
  command->callback([options] {
    if (const int code = run(*options); code != 0) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
