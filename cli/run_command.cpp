// `arkmesh run`: several labs in one process.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "app/count_words.hpp"
#include "app/joint_run.hpp"
#include "app/lab_files.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/page_opener.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "hal/exit_code.hpp"
#include "hal/record/result_file.hpp"
#include "lab/run_folder.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;

struct RunOptions {
  app::LabFiles labs;
  std::string seeds, jobs, out;
  std::int64_t seed = -1;
  double seconds = 0;
  bool force = false, open = false;
};

std::filesystem::path directory_of(const RunOptions& options) {
  if (!options.out.empty()) return options.out;
  std::string names;
  for (const hal::Config& lab : app::read_labs(options.labs, options.seed))
    names += (names.empty() ? "" : "-") + lab.root().section("lab").get("name", std::string());
  return lab::default_run_directory(names);
}

// Each total with those of single labs behind it: "lit 12 (a 5, b 7)".
void print_counts(const nlohmann::json& result) {
  const nlohmann::json& counts = result.at("counts");
  for (const auto& [name, n] : counts.items()) {
    if (name.find('@') != name.npos) continue;
    std::vector<std::string> by_lab;
    for (const std::string lab : result.at("labs"))
      if (const auto own = counts.find(name + "@" + lab); own != counts.end())
        by_lab.push_back(app::count_words(name, own->get<std::uint64_t>(), lab));
    fmt::print("  {}{}\n", app::count_words(name, n.get<std::uint64_t>()),
               by_lab.empty() ? "" : fmt::format(" ({})", fmt::join(by_lab, ", ")));
  }
}

int run(const RunOptions& options) {
  if (!options.seeds.empty() || !options.jobs.empty())
    throw hal::ConfigError(fmt::format("arkmesh run performs one run; for several: arkmesh batch {} --seeds {}",
                                       fmt::join(options.labs.files, " "),
                                       options.seeds.empty() ? "1..20" : options.seeds));
  OperatorStop stop;
  const std::filesystem::path directory = directory_of(options);
  using Folder = app::JointRun::Folder;
  app::JointRun run(app::read_labs(options.labs, options.seed), directory,
                    options.force ? Folder::moved_aside : Folder::must_be_empty, {}, true);
  ProgressLine progress(run.names());
  if (run.page() && options.open) show_page(run.page()->url(), directory, true);
  // A run that is over in a moment takes its page with it.
  if (run.page() && !options.open) progress.say_after(2s, page_words(run.page()->url()));
  const nlohmann::json result = run.run(stop, &progress);
  const std::string not_seen = run.not_standing();
  if (!not_seen.empty()) progress.say("arkmesh: robots were told to stop; not seen standing: " + not_seen);
  const hal::Outcome outcome = hal::outcome_in(result).value_or(hal::Outcome::failed);
  const int code = run.robots_stand() ? exit_code(outcome) : hal::Exit::not_standing;
  if (outcome != hal::Outcome::finished)
    progress.say(fmt::format("arkmesh: run of {} {}: {}", run.names(), run.finished() ? "failed" : "ended early",
                             hal::ended_in(result)));
  if (!run.finished()) return code;
  const nlohmann::json& wall = result.at("wall");
  fmt::print("{}, seed {}: {:.0f} s simulated in {:.1f} s ({:.0f}x), final hash {}\n", run.names(),
             result.at("seed").get<std::uint64_t>(), result.at("duration_s").get<double>(),
             wall.at("total_s").get<double>(), wall.at("speed").get<double>(),
             result.at("final_hash").get<std::string>());
  print_counts(result);
  for (const auto& [lab, figures] : result.at("by_lab").items())
    for (const auto& note : figures.at("notes")) fmt::print("  lab {}: {}\n", lab, note.get<std::string>());
  for (const std::string lab : result.value("absent_labs", nlohmann::json::array()))
    fmt::print("  {} of shared.labs does not take part\n", lab);
  fmt::print("  results in {0}\n  see it with arkmesh view {0}\n", directory.string());
  return code;
}

}  // namespace

void add_run_command(CLI::App* command) {
  auto options = std::make_shared<RunOptions>();
  command->add_option("files", options->labs.files, "A configuration file for each lab")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--seed", options->seed, "Seed of all labs (overrides run.seed)")->check(CLI::NonNegativeNumber);
  command->add_option("--seconds", options->seconds, "Duration of the run (overrides run.duration_s)")
      ->check(CLI::PositiveNumber);
  command->add_option("--seeds", options->seeds)->group("");  // refused, with what to type instead
  command->add_option("--jobs", options->jobs)->group("");
  command->add_option("--out", options->out, "Folder for the results, empty or new (default runs/DATE-TIME-LABS)");
  command->add_flag("--force", options->force, "Move existing contents of the folder to OUT.1");
  command->add_flag("--open", options->open, "Open the page of the labs in a browser");
  command
      ->add_option("--set", options->labs.sets,
                   "Override a key of every lab, or of one: --set gate.slack=1, --set shark:arena.robots=30")
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh run experiments/dhtf/shark.toml experiments/dhtf/roark.toml --seed 7 --set "
      "run.duration_s=600\n"
      "The given labs form the shared world; shared.labs in the files is ignored unless set with --set.");
  command->callback([options] {
    if (options->seconds > 0) options->labs.sets.push_back(fmt::format("run.duration_s={}", options->seconds));
    hand_over_cameras(options->labs.files, options->labs.sets);
    if (const int code = run(*options); code != 0) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
