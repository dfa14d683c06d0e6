// Where a lab's run leaves what it was and gave: the effective configuration, the recording with its tables, and
// result.json.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/config.hpp"
#include "hal/recorder.hpp"

namespace arkmesh::lab {

class RunFolder {
 public:
  // Makes `directory`, writes config.toml and opens the recording. Throws std::runtime_error when it cannot be written.
  RunFolder(const std::filesystem::path& directory, const std::string& effective_config,
            hal::Recorder::Options options);

  const std::filesystem::path& directory() const { return recorder_.directory(); }
  hal::Recorder& recorder() { return recorder_; }
  // Writes result.json. Throws std::runtime_error with one sentence when it cannot be written.
  void save_result(const nlohmann::json& result) const;

 private:
  hal::Recorder recorder_;
};

// [recorder] of a lab's configuration.
struct RecorderConfig {
  bool log = true;
  int keep_free_mib = 64;

  void fields(const hal::Section& recorder);
  hal::Recorder::Options options() const;
};
// The default of --out: runs/DATE-TIME.
std::filesystem::path default_run_directory();

}  // namespace arkmesh::lab
