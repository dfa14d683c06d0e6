// Runs of the same labs for many seeds: each in a process of its own, some at a time, and one table of all.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hal/config.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::app {

// The files of labs that run together, and overrides: "key=value" for all of them, "shark:key=value" for lab shark.
struct LabFiles {
  std::vector<std::string> files, sets;
};

// Joins exactly the labs whose files are given, unless an override sets shared.labs. `seed` overrides run.seed; below
// 0: that of the files. Throws ConfigError.
std::vector<hal::Config> read_labs(const LabFiles& labs, std::int64_t seed);

class Batch {
 public:
  // Seeds first..last, each into `directory`/seed-N, at most `jobs` at a time; what `directory` holds is moved aside
  // with `force`. Throws ConfigError, so that a wrong configuration is said once, before anything starts.
  Batch(LabFiles labs, std::int64_t first, std::int64_t last, int jobs, const std::filesystem::path& directory,
        bool force);

  struct Ended {
    std::int64_t seed = 0;
    bool good = false;
  };
  // Starts runs where there is room, none after a stop, and waits until one ends. Nothing when all have ended.
  std::optional<Ended> next(hal::StopRequest& stop);
  // Writes seeds.csv: a row for each seed that has a result.
  void save_table() const;
  std::filesystem::path table() const { return directory_ / "seeds.csv"; }

 private:
  void start(std::int64_t seed, hal::StopRequest& stop);
  std::filesystem::path folder(std::int64_t seed) const;

  LabFiles labs_;
  std::int64_t first_, last_, next_;
  std::size_t jobs_;
  std::filesystem::path directory_;
  std::map<pid_t, std::int64_t> running_;
};

}  // namespace arkmesh::app
