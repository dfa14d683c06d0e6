#include "app/batch/run_pool.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "app/batch/plain_json.hpp"
#include "app/joint_run.hpp"
#include "hal/record/result_file.hpp"
#include "lab/result.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kept_output = 16 << 10;  // of what a run prints

// Counters of tables that were cut ("shark.recorder.not_recorded.disk_full").
bool lost_records(const nlohmann::json& result) {
  const nlohmann::json& drops = object_in(result, "drops");
  for (const auto& [name, n] : drops.items())
    if (name.find("recorder.not_recorded.disk_full") != std::string::npos) return true;
  return false;
}

// Of a run that could say nothing itself. On a full disk there is none.
void save_failure(const RunTask& task, const std::string& why, hal::Outcome outcome = hal::Outcome::failed) {
  const hal::ResultFile begun(task.directory);
  nlohmann::json result = begun.exists() ? begun.content() : lab::program_facts();
  result["seed"] = task.seed;
  hal::set_outcome(result, outcome, why);
  std::error_code error;
  fs::create_directories(task.directory, error);
  hal::replace_json(task.directory / "result.json", result);
}

int refuse(const RunTask& task, const std::string& why, int code) {
  fmt::print(stderr, "arkmesh: seed {}: {}\n", task.seed, why);
  save_failure(task, why);
  return code;
}

// Of a child: a signal ends its run with a result, a second one too.
class ChildStop final : public hal::StopRequest {
 public:
  ChildStop() {
    for (const int each : {SIGINT, SIGTERM, SIGHUP})
      if (std::signal(each, [](int) { wished = 1; }) == SIG_IGN) std::signal(each, SIG_IGN);  // nohup ignores SIGHUP
  }
  bool stopped() override { return wished != 0; }

 private:
  inline static volatile std::sig_atomic_t wished = 0;
};

// SIGKILL comes from outside, mostly of a machine without memory: the run itself is not at fault.
std::string death_of(const hal::ChildProcess::End& end) {
  if (end.signal == SIGKILL) return "its process was killed, perhaps because memory ran out; try fewer --jobs";
  if (end.signal != 0)
    return fmt::format("its process was ended by signal {} ({})", end.signal, ::strsignal(end.signal));
  return fmt::format("its process ended with exit code {} and no result", end.code);
}

}  // namespace

RunState state_of_run(const fs::path& directory) {
  const hal::ResultFile result(directory);
  if (lost_records(result.content())) return RunState::missing;
  const auto outcome = result.outcome();
  return outcome == hal::Outcome::finished ? RunState::finished
         : outcome == hal::Outcome::failed ? RunState::failed
                                           : RunState::missing;
}

int run_task(const RunTask& task, hal::StopRequest& stop) try {
  std::error_code error;
  fs::remove_all(task.directory, error);
  JointRun run(read_labs(task.labs, task.seed), task.directory, JointRun::Folder::of_batch);
  const nlohmann::json result = run.run(stop, nullptr);
  const auto outcome = hal::outcome_in(result);
  if (outcome == hal::Outcome::finished) return 0;
  fmt::print(stderr, "arkmesh: run of {} ended early: {}\n", run.names(), hal::ended_in(result));
  return outcome == hal::Outcome::stopped ? 3 : 1;
} catch (const hal::ConfigError& e) {
  return refuse(task, e.what(), 2);
} catch (const fs::filesystem_error& e) {
  return refuse(task, fmt::format("{} cannot be written: {}", e.path1().string(), e.code().message()), 1);
} catch (const std::exception& e) {
  return refuse(task, e.what(), 1);
}

RunPool::RunPool(std::deque<RunTask> tasks, std::size_t jobs, std::uintmax_t free_bytes)
    : tasks_(std::move(tasks)), jobs_(jobs), free_bytes_(free_bytes) {}

bool RunPool::has_room(const fs::path& directory) const {
  struct statvfs disk {};
  // the nearest folder that is there
  fs::path there = fs::absolute(directory);
  while (::statvfs(there.c_str(), &disk) != 0 && there.has_relative_path()) there = there.parent_path();
  return static_cast<std::uintmax_t>(disk.f_bavail) * disk.f_frsize >= free_bytes_ || disk.f_frsize == 0;
}

void RunPool::start(RunTask task) try {
  const auto run = [&] {
    for (Running& other : running_) other.process.close_output();
    ChildStop stop;
    return run_task(task, stop);
  };
  hal::ChildProcess process({.function = run, .own_group = false});
  running_.push_back({std::move(task), std::move(process), {}});
} catch (const std::runtime_error& e) {
  throw std::runtime_error(fmt::format("{}; use fewer --jobs", e.what()));
}

void RunPool::start_where_room() {
  while (!tasks_.empty() && running_.size() < jobs_ && !halted()) {
    if (!has_room(tasks_.front().directory)) {
      halted_ = fmt::format("the disk of {} has less than {} MB left", tasks_.front().directory.string(),
                            free_bytes_ / 1'000'000 + 1);
      return;
    }
    RunTask task = std::move(tasks_.front());
    tasks_.pop_front();
    start(std::move(task));
  }
}

void RunPool::read(Running& run) {
  run.process.read(run.said);
  if (run.said.size() > kept_output) run.said.resize(kept_output);
}

RunPool::Ended RunPool::conclude(Running& run, const hal::ChildProcess::End& end) {
  RunState state = state_of_run(run.task.directory);
  const bool stopped = end.code == 3;
  const bool disk_full = lost_records(hal::ResultFile(run.task.directory).content()) || !has_room(run.task.directory);
  if (state == RunState::missing && !stopped && !disk_full) {
    const bool was_killed = end.signal == SIGKILL;
    save_failure(run.task, death_of(end), was_killed ? hal::Outcome::killed : hal::Outcome::failed);
    if (was_killed) run.said = death_of(end);
  }
  if (state != RunState::finished && disk_full) {
    // what a full disk did to it says nothing about the run
    std::error_code error;
    fs::remove_all(run.task.directory, error);
    if (!halted()) halted_ = fmt::format("the disk of {} is full", run.task.directory.string());
  }
  return {run.task.number, state == RunState::finished, std::move(run.said)};
}

std::optional<RunPool::Ended> RunPool::next(hal::StopRequest& stop, std::chrono::milliseconds wait) {
  if (stop.stopped() && halted_ != "stopped") {
    halted_ = "stopped";
    for (const Running& run : running_) run.process.signal(SIGTERM);
  }
  start_where_room();
  std::vector<pollfd> outs;
  for (const Running& run : running_) outs.push_back({run.process.output(), POLLIN, 0});
  if (::poll(outs.data(), outs.size(), static_cast<int>(wait.count())) < 0 && errno != EINTR)
    throw std::runtime_error(fmt::format("cannot wait for runs: {}", std::strerror(errno)));
  for (auto one = running_.begin(); one != running_.end(); ++one) {
    const auto end = one->process.end();
    read(*one);
    if (!end) continue;
    Ended ended = conclude(*one, *end);
    running_.erase(one);
    return ended;
  }
  return {};
}

}  // namespace arkmesh::app
