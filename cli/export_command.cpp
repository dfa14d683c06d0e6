// `arkmesh export`: a recorded run for other programs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/progress_line.hpp"
#include "hal/config/config.hpp"
#include "hal/files/own_files.hpp"
#include "recording/export/exports.hpp"
#include "recording/export/out_file.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

// A kind of export: an option of the command, and what it writes into RUN/export unless --out says otherwise.
struct ExportKind {
  const char* option;
  const char* name;
  const char* help;
  recording::Exported (*write)(const recording::Run& run, const fs::path& to, recording::Watch& watch);  // null: a film
};

// The page's own modules draw it, in a browser without a screen: drawing/film, which tells itself how far it is.
recording::Exported export_film(const recording::Run& run, const fs::path& to, std::optional<double> trails_s) {
  recording::make_folder_of(to);
  std::vector<std::string> arguments{run.folder().string(), "--out", to.string(), "--program",
                                     (hal::program_folder() / "arkmesh").string()};
  if (trails_s) arguments.insert(arguments.end(), {"--trails", fmt::format("{}", *trails_s)});
  const std::string said = hal::watch_script("film", arguments);
  return {said.substr(std::min(said.size(), to.string().size() + 2)), run.notes()};  // "FILE: 150 pictures, 6.0 s"
}

constexpr ExportKind export_kinds[] = {
    {"--csv", "csv", "A folder of CSV files: a table for each channel and each list in its messages",
     recording::export_csv},
    {"--hdf5", "run.h5", "An HDF5 file of the same tables, for Python, R and MATLAB", recording::export_hdf5},
    {"--mcap", "run.mcap", "An MCAP file for Foxglove and Rerun: messages, robots and the arena",
     recording::export_mcap},
    {"--mp4", "film.mp4",
     "A film of the arenas as the page draws them, 20 times faster than real time; drawing/film has more options",
     nullptr},
};

struct ExportOptions {
  std::string run, out;
  bool wanted[std::size(export_kinds)] = {};
  std::optional<double> trails_s;  // of a film
  bool force = false;
};

void export_one(const recording::Run& run, const ExportKind& kind, const ExportOptions& options) {
  const fs::path to = options.out.empty() ? run.folder() / "export" / kind.name : fs::path(options.out);
  std::error_code error;
  const bool is_there = fs::exists(to, error) && !(fs::is_directory(to, error) && fs::is_empty(to, error));
  if (is_there && !options.force)
    throw hal::ConfigError(
        fmt::format("{} exists; choose another place with --out, or overwrite it with --force", to.string()));
  if (kind.write != recording::export_csv && (fs::is_directory(to, error) || !to.has_filename()))
    throw hal::ConfigError(fmt::format("{} is a folder; name the file, as {}", to.string(), (to / kind.name).string()));
  OperatorStop stop;
  ProgressLine progress;
  recording::Exported done;
  {
    recording::Watch watch(progress, stop, kind.name);
    done = kind.write ? kind.write(run, to, watch) : export_film(run, to, options.trails_s);
  }
  if (run.is_growing()) fmt::print(stderr, "arkmesh: the run is unfinished; exporting what it has written so far\n");
  for (const std::string& note : done.notes) fmt::print(stderr, "arkmesh: {}\n", note);
  fmt::print("wrote {}: {}\n", to.string(), done.summary);
}

void export_run(const ExportOptions& options) {
  std::vector<const ExportKind*> kinds;
  for (std::size_t i = 0; i < std::size(export_kinds); ++i)
    if (options.wanted[i]) kinds.push_back(&export_kinds[i]);
  if (kinds.empty()) throw hal::ConfigError("nothing to write: give one or more of --csv, --hdf5, --mcap and --mp4");
  if (kinds.size() > 1 && !options.out.empty())
    throw hal::ConfigError("--out names one file; give only one kind of export with it");
  const recording::Run run(options.run);
  for (const ExportKind* kind : kinds) export_one(run, *kind, options);
}

}  // namespace

void add_export_command(CLI::App* command) {
  const auto options = std::make_shared<ExportOptions>();
  command->add_option("run", options->run, "The folder of a run, or of one of its labs")
      ->required()
      ->check(CLI::ExistingDirectory);
  for (std::size_t i = 0; i < std::size(export_kinds); ++i)
    command->add_flag(export_kinds[i].option, options->wanted[i], export_kinds[i].help);
  command->add_option("--trails", options->trails_s, "Lab time that a film's trails show, s; 0: none; default: 30")
      ->check(CLI::Range(0.0, 1e6))
      ->needs("--mp4");
  command->add_option("--out", options->out, "Output file or folder; default: export/ in the run's folder");
  command->add_flag("--force", options->force, "Replace existing exports");
  command->footer(
      "Examples:\n  arkmesh export runs/demo --hdf5\n  arkmesh export runs/demo/shark --csv --out /tmp/shark\n"
      "  arkmesh export runs/demo --mcap --out demo.mcap\n  arkmesh export runs/demo --mp4 --trails 120\n"
      "Tables are explained in docs/reading-results.md; times are lab time, and names end with units: x_m, age_us.");
  command->callback([options] {
    try {
      export_run(*options);
    } catch (const recording::Stopped& why) {
      fmt::print(stderr, "arkmesh: {}\n", why.what());
      throw CLI::RuntimeError(exit_code(hal::Outcome::stopped));
    }
  });
}

}  // namespace arkmesh::cli
