// `arkmesh plot`: pictures of recorded runs. Drawing is Python's (drawing/plot, drawing/plot_curves), which come with
// the program.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "hal/config/config.hpp"
#include "hal/files/own_files.hpp"
#include "recording/run.hpp"

namespace arkmesh::cli {
namespace {

struct PlotOptions {
  std::vector<std::string> folders, by, series;
  std::string out, at;
  std::map<std::string, std::string> looks;
  bool curves = false;
};

void plot(const PlotOptions& options) {
  // one run has a picture of its end; several, and batches, have curves, from tables: there may be no log
  const bool curves = options.curves || options.folders.size() > 1 || !options.by.empty() || !options.series.empty() ||
                      !recording::is_run(options.folders.front());
  if (curves && !options.at.empty()) throw hal::ConfigError("--at needs a single run; curves cover the whole run");
  for (const char* label : {"xlabel", "ylabel"})
    if (!curves && !options.looks.at(label).empty())
      throw hal::ConfigError(fmt::format("--{} is for curves; both axes of an arena are in metres", label));
  std::vector<std::string> words = options.folders;
  for (const std::string& key : options.by) words.insert(words.end(), {"--by", key});
  for (const std::string& name : options.series) words.insert(words.end(), {"--series", name});
  if (!options.at.empty()) words.insert(words.end(), {"--at", options.at});
  if (!options.out.empty()) words.insert(words.end(), {"--out", options.out});
  for (const auto& [look, value] : options.looks)
    if (!value.empty()) words.insert(words.end(), {"--" + look, value});
  fmt::print("{}\n", hal::run_script(curves ? "plot_curves" : "plot", words));
}

}  // namespace

void add_plot_command(CLI::App* command) {
  const auto options = std::make_shared<PlotOptions>();
  command
      ->add_option(
          "folders", options->folders,
          "The folder of a run (draws its arenas at one moment), several runs or a batch (draws curves over time)")
      ->required()
      ->check(CLI::ExistingDirectory);
  command->add_option("--at", options->at, "Lab time of the picture in seconds; default: the last complete period");
  command->add_flag("--curves", options->curves, "Draw curves of a single run, too");
  command->add_option("--by", options->by, "For a batch: draw a curve for each value of this factor")
      ->allow_extra_args(false);
  command->add_option("--series", options->series, "Curves to draw: completed, swarms.north, ...")
      ->allow_extra_args(false);
  command->add_option("--out", options->out,
                      "Output file (.png, .jpg, .pdf or .svg); default: picture.png or curves.png in the first folder");
  add_looks(command, options->looks);
  command->footer(
      "Examples:\n  arkmesh plot runs/demo --at 600\n  arkmesh plot runs/monday runs/tuesday --out both.png\n"
      "  arkmesh plot runs/dhtf-batch --by pair --series completed\n"
      "  arkmesh plot runs/demo --width column --out figure.pdf\n"
      "Curves of several runs are means with their 95 % intervals.");
  command->callback([options] { plot(*options); });
}

}  // namespace arkmesh::cli
