// `arkmesh rerun`: a run once more, from its folder alone.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/batch/batch_plan.hpp"
#include "app/joint_run.hpp"
#include "app/recorded_run.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/progress_line.hpp"
#include "hal/files/scratch_folder.hpp"
#include "hal/record/result_file.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

struct RerunOptions {
  std::string place, out;
  std::int64_t index = -1;
};

int rerun(const RerunOptions& options) {
  const app::RecordedRun recorded(options.place,
                                  options.index < 0 ? std::nullopt : std::optional<std::size_t>(options.index));
  hand_over_cameras(recorded.config_files(), {});
  for (const std::string& change : recorded.changes()) fmt::print(stderr, "arkmesh: {}\n", change);
  std::optional<hal::ScratchFolder> scratch;
  if (options.out.empty()) scratch.emplace("rerun");
  const fs::path directory = scratch ? scratch->path() / "run" : fs::path(options.out);
  std::error_code error;
  if (fs::exists(directory, error) && !(fs::is_directory(directory, error) && fs::is_empty(directory, error)))
    throw hal::ConfigError(fmt::format("{} is not empty; give an empty or new folder with --out", directory.string()));
  OperatorStop stop;
  app::JointRun run(recorded.configs(), directory);
  ProgressLine progress(run.names());
  const nlohmann::json result = run.run(stop, &progress);
  if (stop.stopped()) return exit_code(hal::Outcome::stopped);
  const std::string now = result.at("final_hash").get<std::string>();
  const bool is_equal = now == recorded.final_hash();
  fmt::print("{}: final hash {}", is_equal ? "equal" : "different", now);
  if (!is_equal) fmt::print(", recorded {}", recorded.final_hash());
  if (const std::string first = recorded.first_difference(directory); !is_equal && !first.empty())
    fmt::print("; the first difference is in {}", first);
  if (!is_equal && !run.finished()) fmt::print("; the repeated run ended early: {}", hal::ended_in(result));
  fmt::print("\n");
  return is_equal ? 0 : 1;
}

}  // namespace

void add_rerun_command(CLI::App* command) {
  auto options = std::make_shared<RerunOptions>();
  command
      ->add_option("run", options->place, "A run's folder, its result.json or config.toml, or a batch's manifest.json")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("--index", options->index, "Number of the run in the batch")
      ->check(CLI::Range(std::int64_t{0}, static_cast<std::int64_t>(app::max_batch_runs) - 1));
  command->add_option("--out", options->out, "Keep the new run in this folder, empty or new");
  command->footer(
      "Examples:\n  arkmesh rerun runs/20240101-120000-roark-shark\n"
      "  arkmesh rerun runs/dhtf-batch/manifest.json --index 17\n"
      "Exit code 0: equal final hash; 1: different.");
  command->callback([options] { end_with(rerun(*options)); });
}

}  // namespace arkmesh::cli
