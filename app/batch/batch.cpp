#include "app/batch/batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "app/batch/batch_manifest.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds quiet{1};            // what takes no longer shows no progress
constexpr std::uintmax_t room_for_a_run = 2 << 20;  // without a message log a run takes less than 0.2 MB

fs::path default_directory(const std::vector<fs::path>& files) {
  std::string name = fs::absolute(files.front()).parent_path().filename().string();
  for (const fs::path& file : files) name += "-" + file.stem().string();
  return fs::path("runs") / name;
}

// An override is written in the experiment file, and the sentence says where.
std::string placed(const BatchPlan& plan, std::size_t setting, std::string sentence) {
  for (const std::string& set : plan.labs_of(setting).sets) {
    const std::string before = "--set " + set + ": ";
    const auto place = plan.places.find(set);
    if (place == plan.places.end() || !sentence.starts_with(before)) continue;
    sentence = fmt::format("{}: {}: {}", place->second, set, sentence.substr(before.size()));
  }
  const std::string name = plan.name_of(setting);
  return name.empty() ? sentence : fmt::format("{} (setting {})", sentence, name);
}

}  // namespace

Batch::Batch(const Request& request)
    : directory_(request.out.empty() ? default_directory(request.files) : request.out),
      file_(read_batch_file(request.files, request.seeds, request.sets)) {}

std::vector<CheckedLab> Batch::check(std::size_t setting) const {
  try {
    return check_labs(read_labs(plan().labs_of(setting), plan().seeds.front()));
  } catch (const hal::ConfigError& error) {
    throw hal::ConfigError(placed(plan(), setting, error.what()));
  }
}

void Batch::begin(BatchFolder::Use use, std::optional<std::size_t> run, hal::Progress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  const bool begun = fs::exists(directory_ / "manifest.json");
  const std::size_t settings = plan().settings();
  std::vector<std::vector<CheckedLab>> checked;
  const bool is_part = run || use == BatchFolder::Use::looking;
  if (is_part && begun)
    checked.push_back(check(run ? plan().setting_of(*run) : 0));
  else
    for (std::size_t setting = 0; setting < settings; ++setting) {
      if (std::chrono::steady_clock::now() - begin > quiet)
        progress.show(fmt::format("checking setting {} of {}", setting + 1, settings));
      checked.push_back(check(setting));
    }
  progress.done();
  for (const auto& labs : checked)
    for (const CheckedLab& lab : labs) keep_free_bytes_ = std::max(keep_free_bytes_, lab.keep_free_bytes);
  folder_ = std::make_unique<BatchFolder>(directory_, make_manifest(file_, checked), use);
}

RunTask Batch::task(std::size_t run) const {
  return {.number = run,
          .labs = plan().labs_of(plan().setting_of(run)),
          .seed = plan().seed_of(run),
          .directory = BatchFolder::run_folder(directory_, run)};
}

RunState Batch::state_of(std::size_t run) const {
  return state_of_run(BatchFolder::run_folder(directory_, run));
}

std::vector<std::size_t> Batch::open_runs(bool failed_too) const {
  std::vector<std::size_t> out;
  for (std::size_t run = 0; run < plan().runs(); ++run) {
    const RunState state = state_of(run);
    if (state == RunState::missing || (failed_too && state == RunState::failed)) out.push_back(run);
  }
  return out;
}

std::uintmax_t Batch::free_bytes(std::size_t jobs) const {
  return keep_free_bytes_ + jobs * room_for_a_run;
}

}  // namespace arkmesh::app
