// `arkmesh lab`: one lab as a process of its own, on its LCM bus; its gateway is another process.
#include "cli/lab_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/lab_process.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/page_opener.hpp"
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "hal/robot_words.hpp"
#include "lab/result.hpp"
#include "lab/run_folder.hpp"

namespace arkmesh::cli {

int run_lab(const LabOptions& options) {
  OperatorStop stop;
  hal::Config config = hal::Config::from_file(options.file, options.sets);
  const std::string name = config.root().section("lab").get("name", std::string(), {.required = true});
  const std::filesystem::path directory =
      options.out.empty() ? lab::default_run_directory(name) : std::filesystem::path(options.out);
  app::LabProcess process(std::move(config), directory, options.force, nullptr, true);
  if (process.page()) show_page(process.page()->url(), directory, options.open);
  ProgressLine progress(name);
  process.run(stop, progress);

  const lab::Runner& runner = process.lab().runner();
  if (const std::string not_seen = hal::in_words(runner.not_standing()); !not_seen.empty())
    progress.say(fmt::format("arkmesh: robots were told to stand; not seen to: {}", not_seen));
  if (!runner.finished()) {
    progress.say(fmt::format("arkmesh: lab {} ended early: {}", name, runner.reason()));
    return exit_code(lab::outcome_of(runner));
  }
  fmt::print("lab {} finished: {} periods, final hash {}, results in {}\n", name, runner.period(),
             lab::hash_text(runner.final_hash()), directory.string());
  return 0;
}

void add_lab_command(CLI::App& app) {
  auto options = std::make_shared<LabOptions>();
  CLI::App* command = add_command(app, "lab");
  command->add_option("file", options->file, "The lab's configuration file")->required()->check(CLI::ExistingFile);
  command->add_option("--out", options->out, "Folder for the results, empty or new (default runs/DATE-TIME-LAB)");
  command->add_flag("--force", options->force, "Move what the folder holds aside, to OUT.1");
  command->add_flag("--open", options->open, "Open the lab's page in a browser");
  command->add_option("--set", options->sets, "Override a key: --set run.seed=7")->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh lab experiments/dhtf/shark.toml &\n  arkmesh gateway experiments/dhtf/shark.toml");
  command->callback([options] {
    hand_over_cameras({options->file}, options->sets);
    if (const int code = run_lab(*options); code != 0) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
