// How far a batch is: a bar with the time left, and a line for each run that failed.
#pragma once

#include <chrono>
#include <cstddef>

#include "app/batch/run_pool.hpp"
#include "hal/progress.hpp"

namespace arkmesh::app {

class BatchProgress {
 public:
  // `open` of `all` runs are to be done now.
  BatchProgress(hal::Progress& line, std::size_t all, std::size_t open)
      : line_(line), all_(all), open_(open), begun_(Clock::now()) {}
  void ended(const RunPool::Ended& run, const RunTask& task);
  // As many runs of now have ended, wherever they run.
  void ended_now(std::size_t ended) { ended_ = ended; }
  void show(std::size_t running);

 private:
  using Clock = std::chrono::steady_clock;
  hal::Progress& line_;
  std::size_t all_, open_, ended_ = 0, failed_ = 0;
  Clock::time_point begun_;
};

}  // namespace arkmesh::app
