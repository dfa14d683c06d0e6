// `arkmesh lab`: one lab as a process of its own, on its LCM bus; its gateway is another process. `arkmesh mark`: one
// that stands in for a lab that runs the published M-ARK software.
#include "cli/lab_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "app/lab_process.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/page_opener.hpp"
#include "cli/progress_line.hpp"
#include "hal/arenas/robot_words.hpp"
#include "hal/bus/loss.hpp"
#include "hal/counted.hpp"
#include "hal/exit_code.hpp"
#include "lab/result.hpp"
#include "lab/run_folder.hpp"
#include "mark/stand_in.hpp"

namespace arkmesh::cli {
namespace {

struct MarkOptions : LabOptions {
  bool server = false, client = false, keys = false;
};

struct LabToRun {
  explicit LabToRun(const LabOptions& options)
      : config(hal::Config::from_file(options.file, options.sets)),
        name(config.root().section("lab").get("name", std::string(), {.required = true})),
        directory(options.out.empty() ? lab::default_run_directory(name) : std::filesystem::path(options.out)) {}

  hal::Config config;
  std::string name;
  std::filesystem::path directory;
};

// Says how it ended, and returns the exit code.
int say_end(const lab::Runner& runner, const LabToRun& what, ProgressLine& progress) {
  if (const std::string not_seen = hal::in_words(runner.not_standing()); !not_seen.empty())
    progress.say(fmt::format("arkmesh: robots were told to stop; not seen standing: {}", not_seen));
  const hal::Outcome outcome = lab::outcome_of(runner);
  const int code = runner.robots_stand() ? exit_code(outcome) : hal::Exit::not_standing;
  if (outcome != hal::Outcome::finished)
    progress.say(fmt::format("arkmesh: lab {} {}: {}", what.name, runner.finished() ? "failed" : "ended early",
                             lab::end_of(runner)));
  if (!runner.finished()) return code;
  fmt::print("lab {} finished: {}, final hash {}, results in {}\n", what.name, hal::counted(runner.period(), "period"),
             lab::hash_text(runner.final_hash()), what.directory.string());
  for (const std::string& note : hal::loss_words(runner.drops(), "arena.")) fmt::print("lab {}: {}\n", what.name, note);
  if (const std::string words = hal::tracking_words(runner.drops(), "arena."); !words.empty())
    fmt::print("lab {}: {}\n", what.name, words);
  std::fflush(stdout);
  return code;
}

// Ctrl-C has ended the lab; the next one ends the process (OperatorStop).
class NobodyAgain final : public hal::StopRequest {
 public:
  bool stopped() override { return false; }
};

int stand_in(const MarkOptions& options) {
  OperatorStop stop;
  LabToRun what(options);
  mark::StandIn original(options.server ? mark::Role::server : mark::Role::client);
  app::LabProcess process(std::move(what.config), what.directory, options.force, &original);
  ProgressLine progress(what.name);
  process.run(stop, progress);
  const int code = say_end(process.lab().runner(), what, progress);
  if (original.is_connected()) {
    progress.say(
        "arkmesh: the original program is still running and would crash if its connection closed; end it first, or "
        "press Ctrl-C (again) to close the connection anyway");
    NobodyAgain nobody;
    original.stay(stop.stopped() ? static_cast<hal::StopRequest&>(nobody) : stop);
  }
  if (code != 0 && !original.conflict().empty()) throw hal::ConfigError(original.conflict());
  return code;
}

}  // namespace

int run_lab(const LabOptions& options) {
  OperatorStop stop;
  LabToRun what(options);
  app::LabProcess process(std::move(what.config), what.directory, options.force, nullptr, true);
  if (process.page()) show_page(process.page()->url(), what.directory, options.open);
  ProgressLine progress(what.name);
  process.run(stop, progress);
  return say_end(process.lab().runner(), what, progress);
}

void add_lab_command(CLI::App* command) {
  auto options = std::make_shared<LabOptions>();
  command->add_option("file", options->file, "The lab's configuration file")->required()->check(CLI::ExistingFile);
  command->add_option("--out", options->out, "Folder for the results, empty or new (default runs/DATE-TIME-LAB)");
  command->add_flag("--force", options->force, "Move existing contents of the folder to OUT.1");
  command->add_flag("--open", options->open, "Open the lab's page in a browser");
  command->add_option("--set", options->sets, "Override a key: --set run.seed=7")->allow_extra_args(false);
  command->footer(
      "Example:\n  arkmesh lab experiments/dhtf/shark.toml &\n  arkmesh gateway experiments/dhtf/shark.toml");
  command->callback([options] {
    hand_over_cameras({options->file}, options->sets);
    end_with(run_lab(*options));
  });
}

void add_mark_command(CLI::App* command) {
  auto options = std::make_shared<MarkOptions>();
  command->add_option("file", options->file, "The lab's configuration file")->check(CLI::ExistingFile);
  auto* const server = command->add_flag("--server", options->server,
                                         "Act as the server: the original M-ARK client connects to mark.address");
  command
      ->add_flag("--client", options->client, "Act as the client: connect to the original M-ARK server at mark.address")
      ->excludes(server);
  command->add_option("--out", options->out, "Folder for the results, empty or new (default runs/DATE-TIME-LAB)");
  command->add_flag("--force", options->force, "Move existing contents of the folder to OUT.1");
  command->add_flag("--keys", options->keys, "List the keys of [mark]");
  command->add_option("--set", options->sets, "Override a key: --set mark.port=7002")->allow_extra_args(false);
  command->footer(
      "Examples:\n  arkmesh gateway experiments/mark/dhtf/argos.toml &\n"
      "  arkmesh mark experiments/mark/dhtf/argos.toml --server         # then start the ARGoS client\n"
      "  arkmesh mark experiments/mark/cre_flying/argos.toml --client   # beside the ARGoS server\n"
      "docs/joining-m-ark.md lists what works.");
  command->callback([options] {
    if (options->keys) return fmt::print("{}", hal::print_keys(hal::keys_of<mark::Settings>("mark")));
    if (options->file.empty()) throw hal::ConfigError("name the lab's configuration file (see arkmesh mark --help)");
    if (options->server == options->client)
      throw hal::ConfigError("give --server if the original is M-ARK's client, or --client if it is its server");
    end_with(stand_in(*options));
  });
}

}  // namespace arkmesh::cli
