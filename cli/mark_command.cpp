// `arkmesh mark`: a lab on its LCM bus that stands in for one that runs the published M-ARK software.
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
#include "cli/program.hpp"
#include "cli/progress_line.hpp"
#include "lab/result.hpp"
#include "lab/run_folder.hpp"
#include "mark/stand_in.hpp"

namespace arkmesh::cli {
namespace {

struct MarkOptions {
  std::string file, out;
  std::vector<std::string> sets;
  bool server = false, client = false, force = false, keys = false;
};

// Ctrl-C has ended the lab; the next one ends the process (OperatorStop).
class NobodyAgain final : public hal::StopRequest {
 public:
  bool stopped() override { return false; }
};

int stand_in(const MarkOptions& options) {
  OperatorStop stop;
  hal::Config config = hal::Config::from_file(options.file, options.sets);
  const std::string name = config.root().section("lab").get("name", std::string(), {.required = true});
  const std::filesystem::path directory =
      options.out.empty() ? lab::default_run_directory(name) : std::filesystem::path(options.out);
  mark::StandIn original(options.server ? mark::Role::server : mark::Role::client);
  app::LabProcess process(std::move(config), directory, options.force, &original);
  ProgressLine progress(name);
  process.run(stop, progress);

  const lab::Runner& runner = process.lab().runner();
  if (runner.finished())
    fmt::print("lab {} finished: {} periods, final hash {}, results in {}\n", name, runner.period(),
               lab::hash_text(runner.final_hash()), directory.string());
  else
    progress.say(fmt::format("arkmesh: lab {} ended early: {}", name, runner.reason()));
  std::fflush(stdout);
  if (original.is_connected()) {
    progress.say(
        "arkmesh: the original still runs, and would die if its connection were closed: end it, or press "
        "Ctrl-C (again) to close it all the same");
    NobodyAgain nobody;
    original.stay(stop.stopped() ? static_cast<hal::StopRequest&>(nobody) : stop);
  }
  if (runner.finished()) return 0;
  if (!original.conflict().empty()) throw hal::ConfigError(original.conflict());
  return exit_code(lab::outcome_of(runner));
}

}  // namespace

void add_mark_command(CLI::App& app) {
  auto options = std::make_shared<MarkOptions>();
  CLI::App* command = add_command(app, "mark");
  command->add_option("file", options->file, "The lab's configuration file")->check(CLI::ExistingFile);
  auto* const server = command->add_flag("--server", options->server,
                                         "Be the server: the original M-ARK client connects to mark.address");
  command->add_flag("--client", options->client, "Be the client: connect to the original M-ARK server there")
      ->excludes(server);
  command->add_option("--out", options->out, "Folder for the results, empty or new (default runs/DATE-TIME-LAB)");
  command->add_flag("--force", options->force, "Move what the folder holds aside, to OUT.1");
  command->add_flag("--keys", options->keys, "List the keys of [mark] and end");
  command->add_option("--set", options->sets, "Override a key: --set mark.port=7002")->allow_extra_args(false);
  command->footer(
      "Examples:\n  arkmesh gateway experiments/mark/dhtf/argos.toml &\n"
      "  arkmesh mark experiments/mark/dhtf/argos.toml --server         # then start the ARGoS client\n"
      "  arkmesh mark experiments/mark/cre_flying/argos.toml --client   # beside the ARGoS server\n"
      "docs/joining-m-ark.md tells what works.");
  command->callback([options] {
    if (options->keys) return fmt::print("{}", hal::print_keys(hal::keys_of<mark::Settings>("mark")));
    if (options->file.empty()) throw hal::ConfigError("name the lab's configuration file (see arkmesh mark --help)");
    if (options->server == options->client)
      throw hal::ConfigError("say --server, when the original is M-ARK's client, or --client, when it is its server");
    if (const int code = stand_in(*options); code != 0) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
