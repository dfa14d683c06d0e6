// Runs of a batch as a job array of Slurm: its commands sbatch and squeue are all that is used.
#pragma once

#include <string>
#include <vector>

#include "app/batch/batch.hpp"
#include "hal/progress.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::app {

struct SlurmRequest {
  Batch::Request batch;              // as the tasks are told it
  std::vector<std::string> options;  // of sbatch
  bool failed_too = false;           // runs that failed are done again
};

// Submits what is still to be done, or finds the array that was submitted for this folder and is not over, and waits
// until it is. A stop leaves it running. Returns what kept it from its end, or nothing. Throws std::runtime_error with
// Slurm's words when it refuses, ConfigError when it is not installed.
std::string run_on_slurm(const Batch& batch, const SlurmRequest& wanted, hal::StopRequest& stop, hal::Progress& line);

}  // namespace arkmesh::app
