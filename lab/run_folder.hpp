// Where a lab's run leaves what it was and gave: the effective configuration, the recording with its tables, and
// result.json. No run overwrites another one.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/config/config.hpp"
#include "hal/record/recorder.hpp"

namespace arkmesh::lab {

class RunFolder {
 public:
  // Writes config.toml, opens the recording, and says in result.json that the run of these `facts` goes on; a killed
  // run leaves it at that. Throws ConfigError when another run has the folder, and std::runtime_error when it cannot be
  // written.
  RunFolder(const std::filesystem::path& directory, const std::string& effective_config, hal::Recorder::Options options,
            const nlohmann::json& facts);
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  const std::filesystem::path& directory() const { return recorder_.directory(); }
  hal::Recorder& recorder() { return recorder_; }
  // Replaces result.json. On a full disk there is room for it; where it cannot be written it goes to the standard
  // output.
  void save_result(const nlohmann::json& result) const;

 private:
  hal::Recorder recorder_;
  std::filesystem::path reserve_;  // room for the result
};

// [recorder] of a lab's configuration.
struct RecorderConfig {
  bool log = true;
  bool compress = false;
  int keep_free_mib = 64;
  double fast_mb_per_s = 10;

  void fields(const hal::Section& recorder);
  hal::Recorder::Options options() const;
};

// The default of --out: runs/DATE-TIME-NAME, or the first of runs/DATE-TIME-NAME-2, ... that is not there yet.
std::filesystem::path default_run_directory(const std::string& name);
// Makes the folder of a run; marks those beside it whose process was killed. One that holds something is refused with a
// ConfigError, or with `force` moved aside to DIRECTORY.1, .2, ..., unless its run still goes on.
void claim_run_folder(const std::filesystem::path& directory, bool force);

}  // namespace arkmesh::lab
