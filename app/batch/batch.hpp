// A batch from its experiment file, or from its labs' files: what is to be run, what has been run, and where. `arkmesh
// batch` does the work with a RunPool.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/batch/batch_file.hpp"
#include "app/batch/batch_folder.hpp"
#include "app/batch/run_pool.hpp"
#include "app/lab_check.hpp"
#include "hal/progress.hpp"

namespace arkmesh::app {

class Batch {
 public:
  struct Request {
    std::vector<std::filesystem::path> files;  // an experiment file, or labs' files
    std::filesystem::path out;      // empty for runs/FOLDER-NAME of the file, with the names of all labs' files
    std::string seeds;              // replaces the experiment's; empty: does not
    std::vector<std::string> sets;  // further overrides of all runs
  };
  // Reads the files; nothing is written. Throws ConfigError.
  explicit Batch(const Request& request);

  // Makes the labs of every setting, so that what is wrong is said before anything starts, and opens the folder. With
  // `run`, the number of a single one, only its setting, when the folder was begun. Throws ConfigError.
  void begin(BatchFolder::Use use, std::optional<std::size_t> run, hal::Progress& progress);

  const BatchPlan& plan() const { return file_.plan; }
  const std::filesystem::path& directory() const { return directory_; }
  RunTask task(std::size_t run) const;
  RunState state_of(std::size_t run) const;
  // Keeps one run of the folder to this process while it lives. False: another one is at it.
  bool take_run(std::size_t run) { return folder_->take_run(run); }
  // Numbers of the runs that are to be done still; those that failed count with `failed_too`.
  std::vector<std::size_t> open_runs(bool failed_too) const;
  // What the disk must have left for a run to start, when so many run at a time.
  std::uintmax_t free_bytes(std::size_t jobs) const;

 private:
  std::vector<CheckedLab> check(std::size_t setting) const;

  std::filesystem::path directory_;
  BatchFile file_;
  std::uintmax_t keep_free_bytes_ = 0;
  std::unique_ptr<BatchFolder> folder_;
};

}  // namespace arkmesh::app
