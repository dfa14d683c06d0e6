// `arkmesh fit`: what a lab's own robots are like, for its simulation and its tracker. Estimating and drawing are
// Python's (drawing/fit_robots), which come with the program.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "hal/config/config.hpp"
#include "hal/exit_code.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::cli {
namespace {

struct FitOptions {
  WalkOptions walk;
  std::string lab, out = "robots.toml", png;
};

void fit_robots(FitOptions options, RecordWalks record_walks) {
  std::string source = options.walk.file;
  if (!std::filesystem::is_directory(source) && !source.ends_with(".csv")) {
    if (!options.lab.empty()) throw hal::ConfigError("--lab needs the folder of a run; a lab's file describes one lab");
    if (!record_walks)
      throw hal::ConfigError(source +
                             " is a lab's file, and this program was built without OpenCV; give the folder of a run");
    options.walk.table = std::filesystem::path(options.out).replace_extension(".tracks.csv").string();
    record_walks(options.walk);
    source = options.walk.table;
  }
  std::vector<std::string> words{source, "--out", options.out};
  if (!options.lab.empty()) words.insert(words.end(), {"--lab", options.lab});
  if (!options.png.empty()) words.insert(words.end(), {"--png", options.png});
  fmt::print("{}\n", hal::watch_script("fit_robots", words));
}

struct CheckOptions {
  std::vector<std::string> runs;
  std::string lab, png = "check.png";
};

// Exit code 1: the runs are not alike.
int fit_check(const CheckOptions& options) {
  std::vector<std::string> words = options.runs;
  words.insert(words.end(), {"--out", options.png});
  if (!options.lab.empty()) words.insert(words.end(), {"--lab", options.lab});
  const std::string said = hal::watch_script("fit_check", words);
  fmt::print("{}\n", said);
  return said.find("\nfit_check: alike") != std::string::npos ? 0 : 1;
}

}  // namespace

void add_fit_command(CLI::App* command, RecordWalks record_walks) {
  command->require_subcommand(1);
  CLI::App* const robots = command->add_subcommand(
      "robots", "Estimate speed, turns, drift, noise and LED bearing of each robot, and write a robots_file");
  const auto options = std::make_shared<FitOptions>();
  robots
      ->add_option("source", options->walk.file,
                   "A lab's file (its robots drive and are tracked), the folder of a recorded run, or a table from "
                   "arkmesh track --csv")
      ->required()
      ->check(CLI::ExistingPath);
  robots->add_option("--out", options->out, "Output file")->capture_default_str();
  robots->add_option("--png", options->png, "Figure of each robot's fit (default: as --out, with .png)");
  robots->add_option("--lab", options->lab, "For a run of several labs: whose robots to fit");
  robots->add_option("--seconds", options->walk.seconds, "For a lab's file: driving time")
      ->check(CLI::Range(60.0, 1e5))
      ->capture_default_str();
  robots->add_option("--ids", options->walk.ids, "For a lab's file: which robots, such as 0-11,40 (default: all)");
  robots->add_option("--set", options->walk.sets, "For a lab's file: override a key: --set arena.use=kilobot")
      ->allow_extra_args(false);
  robots->footer(
      "Examples:\n  arkmesh fit robots lab.toml\n  arkmesh fit robots runs/walk --lab roark --out robots.toml\n"
      "Real robots must run firmware/fit_robots.c, and need an id of their own and free space; simulated ones run\n"
      "it already. From runs of other programs only speed, drift and noise are estimated. Parameters that the "
      "tracks\ndo not determine are listed, and keep the preset's values. Use the file as arena.ode.robots_file and "
      "as\n"
      "arena.kilobot.robots_file.");
  robots->callback([options, record_walks] { fit_robots(*options, record_walks); });

  CLI::App* const check = command->add_subcommand("check", "Compare how robots walk in a real and a simulated run");
  const auto checked = std::make_shared<CheckOptions>();
  check->add_option("runs", checked->runs, "The folders of two recorded runs of the same program")
      ->required()
      ->expected(2)
      ->check(CLI::ExistingDirectory);
  check->add_option("--lab", checked->lab, "For runs of several labs: whose robots to compare");
  check->add_option("--png", checked->png, "Output figure (.png, .jpg, .pdf or .svg)")->capture_default_str();
  check->footer(
      "Example:\n  arkmesh fit check runs/real runs/simulated --png check.pdf\n"
      "Compares squared displacement, turns and distances to the nearest neighbour, with bootstrap intervals "
      "over\nrobots. Exit code 1 if the runs are not alike.");
  check->callback([checked] { end_with(fit_check(*checked)); });
}

}  // namespace arkmesh::cli
