#include "app/batch/slurm_array.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "app/batch/batch_progress.hpp"
#include "hal/child_process.hpp"
#include "hal/config/config.hpp"
#include "hal/files/own_files.hpp"
#include "hal/files/replace_file.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::size_t max_tasks = 1000;  // Slurm's MaxArraySize is 1001 unless somebody changed it
constexpr auto ask_every = 2s;

// A word that a shell takes as it is.
std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string first_line(std::string text) {
  text.erase(std::min(text.find('\n'), text.size()));
  return text;
}

// Line N lists the runs of task N.
std::string task_lines(const std::vector<std::size_t>& runs) {
  const std::size_t tasks = std::min(runs.size(), max_tasks);
  std::string out;
  for (std::size_t task = 0; task < tasks; ++task) {
    for (std::size_t i = task; i < runs.size(); i += tasks) out += fmt::format("{} ", runs[i]);
    out += "\n";
  }
  return out;
}

std::string job_script(const Batch& batch, const SlurmRequest& wanted, const fs::path& tasks) {
  const Batch::Request& request = wanted.batch;
  const fs::path program = hal::this_program();
  std::string command = quoted(program.string()) + " batch";
  for (const fs::path& file : request.files) command += " " + quoted(fs::absolute(file).string());
  command += " --out " + quoted(fs::absolute(batch.directory()).string());
  if (!request.seeds.empty()) command += " --seeds " + quoted(request.seeds);
  for (const std::string& set : request.sets) command += " --set " + quoted(set);
  if (wanted.failed_too) command += " --retry";
  return fmt::format(
      "#!/bin/sh\n"
      "# The runs of one task of the array, one after another; a run that fails is a row of the table.\n"
      "code=0\n"
      "for run in $(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" {}); do\n"
      "  {} --index \"$run\" || code=$?\n"
      "done\n"
      "exit $code\n",
      quoted(fs::absolute(tasks).string()), command);
}

// The number of a job that is not over; empty when there is none.
std::string job_under_way(const fs::path& file) {
  std::ifstream in(file);
  std::string job;
  if (!std::getline(in, job) || job.empty()) return {};
  const hal::Finished asked = hal::run_to_end({.command = {"squeue", "--noheader", "--jobs", job}});
  return asked.status == 0 && asked.output.find_first_not_of(" \n") != std::string::npos ? job : std::string();
}

std::string submit(const Batch& batch, const SlurmRequest& wanted, const std::vector<std::size_t>& runs,
                   const fs::path& folder) {
  fs::create_directories(folder);
  hal::must_replace_file(folder / "tasks.txt", task_lines(runs));
  hal::must_replace_file(folder / "job.sh", job_script(batch, wanted, folder / "tasks.txt"));
  std::vector<std::string> command = {
      "sbatch",
      "--parsable",
      "--job-name=arkmesh",
      fmt::format("--array=0-{}", std::min(runs.size(), max_tasks) - 1),
      "--output=" + (fs::absolute(folder) / "task-%a.txt").string(),
  };
  command.insert(command.end(), wanted.options.begin(), wanted.options.end());
  command.push_back((folder / "job.sh").string());
  const hal::Finished said = hal::run_to_end({.command = command});
  if (said.status == 127)
    throw hal::ConfigError("--slurm: sbatch is not installed; install slurm-client, or omit --slurm");
  if (said.status != 0) throw std::runtime_error(fmt::format("Slurm refused the job: {}", first_line(said.output)));
  // "12;cluster"
  std::string job = first_line(said.output);
  job.erase(std::min(job.find(';'), job.size()));
  hal::must_replace_file(folder / "job.txt", job + "\n");
  return job;
}

}  // namespace

std::string run_on_slurm(const Batch& batch, const SlurmRequest& wanted, hal::StopRequest& stop, hal::Progress& line) {
  const fs::path folder = batch.directory() / "slurm";
  std::string job = job_under_way(folder / "job.txt");
  const std::vector<std::size_t> open = batch.open_runs(wanted.failed_too);
  if (open.empty()) return {};
  const bool is_new = job.empty();
  if (is_new) job = submit(batch, wanted, open, folder);
  line.say(fmt::format("job {} {}", job, is_new ? "is submitted" : "is running"));
  BatchProgress progress(line, batch.plan().runs(), open.size());
  for (auto asked = std::chrono::steady_clock::now(); !stop.stopped(); std::this_thread::sleep_for(100ms)) {
    if (std::chrono::steady_clock::now() - asked < ask_every) continue;
    asked = std::chrono::steady_clock::now();
    const bool under_way = !job_under_way(folder / "job.txt").empty();
    progress.ended_now(open.size() - std::min(open.size(), batch.open_runs(false).size()));
    progress.show(under_way ? 1 : 0);
    if (under_way) continue;
    line.done();
    return batch.open_runs(false).empty() ? "" : fmt::format("job {} has ended", job);
  }
  line.say(fmt::format("job {} continues; repeat the command to wait for it, or end it with scancel {}", job, job));
  return "stopped";
}

}  // namespace arkmesh::app
