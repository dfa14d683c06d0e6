// Runs of a batch as a job array of Slurm: its commands sbatch and squeue are all that is used.
#pragma once

#include <string>
#include <vector>

#include "app/batch.hpp"
#include "cli/progress_line.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::cli {

// Submits what is still to be done, or finds the array that was submitted for this folder and is not over, and waits
// until it is. A stop leaves it running. Returns what kept it from its end, or nothing. Throws std::runtime_error with
// Slurm's words when it refuses, ConfigError when it is not installed.
std::string run_on_slurm(const app::Batch& batch, const app::Batch::Request& request,
                         const std::vector<std::string>& options, bool failed_too, hal::StopRequest& stop,
                         ProgressLine& line);

}  // namespace arkmesh::cli
