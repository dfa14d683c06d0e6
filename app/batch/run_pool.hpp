// Runs of labs, each in a process of its own, some at a time. None outlives this process, however it ends.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <list>
#include <optional>
#include <string>

#include "app/lab_files.hpp"
#include "hal/child_process.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::app {

struct RunTask {
  std::size_t number = 0;  // the caller's
  LabFiles labs;
  std::int64_t seed = 0;
  std::filesystem::path directory;  // what it holds is removed before the run
};

class RunPool {
 public:
  // `free_bytes`: no run is started while the disk of its folder has less left. What still runs at its end is killed,
  // without a result.
  RunPool(std::deque<RunTask> tasks, std::size_t jobs, std::uintmax_t free_bytes);

  struct Ended {
    std::size_t number = 0;
    bool finished = false;  // with a result, and all of its tables
    std::string said;       // what the run printed
  };
  // Starts runs where there is room, none after a stop or on a full disk, and waits at most `wait` until one ends. A
  // run that fails leaves a result.json that says why, also when its process died; but none when the disk is full,
  // which is no fault of the run. One that somebody killed (SIGKILL) is none that failed: it says so, and is still to
  // be done.
  std::optional<Ended> next(hal::StopRequest& stop, std::chrono::milliseconds wait);
  // Nothing runs, and nothing is going to be started.
  bool done() const { return running_.empty() && (tasks_.empty() || halted()); }
  // No run is started any more: "the disk of runs/x has 3 MB left", or "stopped".
  bool halted() const { return !halted_.empty(); }
  const std::string& why_halted() const { return halted_; }
  std::size_t running() const { return running_.size(); }

 private:
  struct Running {
    RunTask task;
    hal::ChildProcess process;
    std::string said;
  };
  void start(RunTask task);
  void start_where_room();
  void read(Running& run);
  Ended conclude(Running& run, const hal::ChildProcess::End& end);
  bool has_room(const std::filesystem::path& directory) const;

  std::deque<RunTask> tasks_;
  std::size_t jobs_;
  std::uintmax_t free_bytes_;
  std::list<Running> running_;
  std::string halted_;
};

// Of a run's folder.
enum class RunState : std::uint8_t { missing, finished, failed };
// missing: not begun, half-written, stopped by the operator, killed from outside, or with tables that a full disk cut.
RunState state_of_run(const std::filesystem::path& directory);

// The run of a task in this process, which goes on or ends as the run did: 0 finished, 1 failed, 2 refused, 3 stopped.
// Sentences go to the standard error.
int run_task(const RunTask& task, hal::StopRequest& stop);

}  // namespace arkmesh::app
